"""Richardson's extrapolation of motions against finer chains."""

from dataclasses import replace

import numpy as np
import pytest
from references import along, moving

from contarm_sim.errors import InputError
from contarm_sim.model.arm import Arm
from contarm_sim.motion.simulate import ACCURATE, simulate


def _rms(one, other):
    return np.sqrt(np.mean(np.sum((one - other) ** 2, axis=-1)))


@pytest.mark.parametrize("load", [{}, {"gravity": (0.0, 0.0, 9.81), "payload": 0.1}], ids=["free", "loaded"])
def test_two_coarse_chains_beat_a_fine_one(load):
    """16 and 8 links together leave less than 24 alone; the reference is 48 extrapolated from 24, ten times as fine."""
    arm = Arm(**load)
    spiral = along(arm, duration=4.0, turns=0.8)

    def moved(links, extrapolate):
        return simulate(replace(arm, links=links), spiral, stepping=ACCURATE, extrapolate=extrapolate)

    truth, alone = moved(48, True), moved(24, False)
    both, most = moved(16, True), moved(24, True)
    tips = [samples.stations[:, -1] for samples in (truth, alone, both, most)]
    assert _rms(tips[2], tips[0]) < 0.4 * _rms(tips[1], tips[0])
    assert _rms(tips[3], tips[0]) < 0.1 * _rms(tips[1], tips[0])
    middle = [samples.stations[:, (samples.stations.shape[1] - 1) // 2] for samples in (truth, alone, most)]
    assert _rms(middle[2], middle[0]) < 0.15 * _rms(middle[1], middle[0])
    np.testing.assert_allclose(
        most.tip_rotation @ most.tip_rotation.swapaxes(1, 2), np.eye(3)[None].repeat(len(most), 0), atol=1e-12
    )
    assert np.array_equal(most.setpoint, alone.setpoint)


def test_too_few_links_are_refused():
    arm = Arm(links=6)
    with pytest.raises(InputError, match="at least 8"):
        simulate(arm, moving(arm, np.zeros((1, 2))), extrapolate=True)
