"""Tests of one skill on a real simulated robot: the rig, and the pytest plugin with it.

    def test_reach_touches_what_it_sees(rig):
        result = rig.run("reach", target=(0.4, 0.2, 0.9))
        assert result.succeeded, result.feedback
        assert rig.hand_distance("left", (0.4, 0.2, 0.9)) < 0.02

The fixture :func:`rig` is there as soon as ``humanoid_bt`` is installed.
"""
