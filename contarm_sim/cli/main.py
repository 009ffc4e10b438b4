"""Entry point of `contarm`."""
def main() -> None:
    """Run."""
    print("contarm")
