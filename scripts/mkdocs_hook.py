"""MkDocs' hook: the reference pages, equations as MathML, and the repository's address from pyproject.toml.

Reference pages are made from what there is, so that nobody has to list modules: one page for each package of
contarm_sim, one for all commands. Equations become MathML while the site is built: they need neither a script nor a
network.
"""

from __future__ import annotations

import html
import re
import sys
import tomllib
from pathlib import Path

from mkdocs.structure.files import File, Files

ROOT = Path(__file__).resolve().parents[1]
PACKAGE = ROOT / "contarm_sim"
FUNCTION = re.compile(r"(<mi>(?:sin|cos|tan)</mi>)(?=<m[is])")
EQUATION = re.compile(r'<(span|div) class="arithmatex">\\([(\[])(.*?)\\[)\]]</\1>', re.DOTALL)


def packages() -> list[str]:
    """Return the dotted names of the packages, contarm_sim itself first."""
    found = sorted(file.parent.relative_to(ROOT) for file in PACKAGE.rglob("__init__.py"))
    return [".".join(path.parts) for path in found]


def modules(package: str) -> list[str]:
    """Return the dotted names of a package's public modules."""
    files = sorted((ROOT / package.replace(".", "/")).glob("*.py"))
    return [f"{package}.{file.stem}" for file in files if not file.stem.startswith("_")]


def package_page(package: str) -> str:
    """Return the Markdown of a package's reference page."""
    parts = [f"# {package}", f"::: {package}\n    options: {{members: false, show_root_heading: false}}"]
    return "\n\n".join([*parts, *(f"::: {module}" for module in modules(package))]) + "\n"


def commands_page() -> str:
    """Return the Markdown of the page of all commands: what `contarm COMMAND --help` prints."""
    sys.path.insert(0, str(ROOT))
    from click import Context

    from contarm_sim.cli.main import cli

    top = Context(cli, info_name="contarm", max_content_width=100)
    pages = [("contarm", cli.get_help(top))]
    for name in cli.list_commands(top):
        command = cli.get_command(top, name)
        pages.append((f"contarm {name}", command.get_help(Context(command, info_name=name, parent=top))))
    return "# Commands\n\n" + "\n\n".join(f"## {name}\n\n```text\n{text}\n```" for name, text in pages) + "\n"


def on_config(config):
    """Bring in the repository's address, and list the reference pages in the navigation."""
    urls = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"].get("urls", {})
    config.repo_url = urls.get("Repository")
    pages = ["reference/commands.md", *(f"reference/{name}.md" for name in packages())]
    for entry in config.nav:
        if "Reference" in entry:
            entry["Reference"] = pages
    return config


def on_files(files: Files, config):
    """Add the reference pages, and the pages that stand at the repository's root."""
    for name in ("CONTRIBUTING", "CHANGELOG"):
        text = (ROOT / f"{name}.md").read_text().replace("](docs/", "](")
        files.append(File.generated(config, f"{name.lower()}.md", content=text))
    files.append(File.generated(config, "reference/commands.md", content=commands_page()))
    for name in packages():
        files.append(File.generated(config, f"reference/{name}.md", content=package_page(name)))
    return files


def on_page_content(text: str, page, config, files) -> str:
    """Turn equations into MathML."""
    from latex2mathml.converter import convert

    def mathml(match: re.Match[str]) -> str:
        made = convert(html.unescape(match[3]), display="block" if match[2] == "[" else "inline")
        return FUNCTION.sub(r'\1<mspace width="0.2em"/>', made)  # or `sin h` reads as `sinh`

    return EQUATION.sub(mathml, text)
