"""Tests of skills and trees on a simulated robot: the rig, the stage, the pytest plugin.

    def test_reach_touches_what_it_sees(rig):
        result = rig.run("reach", target=(0.4, 0.2, 0.9))
        assert result.succeeded, result.feedback
        assert rig.hand_distance("left", (0.4, 0.2, 0.9)) < 0.02

    def test_fetch_stops_when_somebody_presses_the_button(rig):
        run = rig.run_tree("fetch", script=[{"at": "2 s", "estop": {}}])
        assert run.outcome == "stopped"

The fixture :func:`rig` is there as soon as ``humanoid_bt`` is installed.
"""
