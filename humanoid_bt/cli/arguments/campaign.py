"""The arguments of ``humanoid-bt campaign``."""

from __future__ import annotations

from pathlib import Path

from humanoid_bt.cli.arguments.numbers import COUNT, number, size
from humanoid_bt.cli.arguments.parsing import EXIT_CODES, Commands, Parser, add_perception, add_workspace
from humanoid_bt.session.limits import DURATION, Limit

_WHOLE = Limit(int, "a whole number, 0 or more", lambda value: value >= 0)

_DESCRIPTION = """\
Run a tree many times, and say how often it succeeds, how sure that is, and why
it fails. Or compare two campaigns trial by trial; or run one trial again.
"""

_USAGE = """\
humanoid-bt campaign [-h] TREE|FILE [options]
       humanoid-bt campaign [-h] compare A B
       humanoid-bt campaign [-h] rerun DIR TRIAL"""

_COMPARE = """\
Compare two campaigns trial by trial: those with the same seed, and the same of
all else that varies. A and B are folders of results.
"""

_COMPARE_EXAMPLES = """\
examples:
  humanoid-bt campaign compare runs/before runs/after
  humanoid-bt campaign compare runs/before runs/after --out comparison.md

exit codes:
  0    nothing got worse beyond chance
  1    something got worse
  2    usage, or there is no campaign in a folder
"""

_RERUN = """\
Run a trial of a campaign again, record and explain it, and say whether it went
as it had gone before. DIR is the folder of results, TRIAL a number or id there.
"""

_RERUN_EXAMPLES = f"""\
examples:
  humanoid-bt campaign rerun runs/slippery 17

{EXIT_CODES}"""

_EXAMPLES = """\
examples:
  humanoid-bt campaign fetch --scene random_target --seeds 0-999 -j 2
  humanoid-bt campaign fetch --set stop_distance=35cm --set stop_distance=40cm    both
  humanoid-bt campaign fetch --set look=5s..9s --condition friction=0.5..1.2      drawn for each trial
  humanoid-bt campaign fetch --push at=1s..6s,force=20..80,direction=-180deg..180deg
  humanoid-bt campaign fetch --scene random_target --perception color_blob --seeds 1-50
  humanoid-bt campaign campaigns/slippery.yaml --require 'success >= 95 %'
  humanoid-bt campaign campaigns/slippery.yaml --out runs/slippery --resume       go on after a kill
  humanoid-bt campaign compare runs/before runs/after
  humanoid-bt campaign rerun runs/slippery 17                                     recorded and explained

results, in the folder --out:
  report.html, report.md       for people; summary.json for programs
  results.csv, .parquet        a trial each; the same for any -j, and after a kill
  wall_clock.csv               what each trial took
  recordings/                  of some failures of each cause

exit codes:
  0    all trials are done, and what is required holds; compare: nothing got worse beyond chance
  1    something that is required does not hold; compare: something got worse; rerun: it failed
  2    usage, or a mistake in a file
  4    every trial ended with an exception in a skill, died or hung; an internal error; the results cannot be written
  130  interrupted; --resume goes on
"""


def add_campaign(commands: Commands) -> None:
    """Declare ``campaign``."""
    campaign = commands.add("campaign", "run a tree many times", _DESCRIPTION, _EXAMPLES)
    campaign.usage = _USAGE
    campaign.add_argument("what", nargs="+", metavar="TREE|FILE", help="name or file of a tree, or of a campaign")
    vary = campaign.add_argument_group("what is tried (in a campaign file too; given here it takes that one's place)")
    vary.add_argument("--scene", action="append", metavar="S", help="a scene; given several times, all are tried")
    vary.add_argument("--robot", action="append", metavar="R", help="a robot; given several times, all are tried")
    add_perception(vary)
    vary.add_argument(
        "--seeds", metavar="N-M", help="each is tried with everything else, as 3,17,100-199; default 0-99"
    )
    vary.add_argument(
        "--set",
        action="append",
        default=[],
        metavar="NAME=VALUE",
        dest="overrides",
        help="a parameter of the tree; given several times, all values are tried; LOW..HIGH is drawn for each trial",
    )
    vary.add_argument(
        "--condition",
        action="append",
        default=[],
        metavar="NAME=VALUE",
        dest="conditions",
        help="what is different from the files, in the same way: friction, drives, perception_noise (factors), "
        "payload, hand_payload, drive_delay, encoder_error, slope, uphill, plates",
    )
    vary.add_argument(
        "--push",
        action="append",
        default=[],
        metavar="NAME=VALUE,...",
        dest="pushes",
        help="push the torso in every trial: at, force, direction, duration, each a value or LOW..HIGH",
    )
    vary.add_argument("--duration", type=number(DURATION), metavar="S", help="longest simulated time of a trial")
    vary.add_argument(
        "--dry", action="store_true", default=None, help="without physics, for the logic of the tree alone"
    )
    judge = campaign.add_argument_group("what comes of it")
    judge.add_argument(
        "--out", type=Path, metavar="DIR", help="folder of the results; default: runs/campaign-NAME-TIME"
    )
    judge.add_argument(
        "--resume", action="store_true", help="go on with the campaign in --out; trials that are done stay"
    )
    judge.add_argument(
        "--require",
        action="append",
        default=[],
        metavar="EXPR",
        help="what has to hold, as 'success >= 95 %%', 'success_low > 90 %%', 'fell == 0', 'time_p95 < 30 s', "
        "'hand_error_median < 1 cm'; may be given several times; what a campaign file requires has to hold, too",
    )
    judge.add_argument(
        "--fail-on",
        action="append",
        metavar="WHAT",
        help="count a trial as a failure whose tree succeeded, if the robot fell, bumped (touched something that no "
        "hand was sent to) or was stopped; may be given several times",
    )
    judge.add_argument(
        "--recordings",
        type=number(_WHOLE),
        metavar="N",
        help="how many failures of each cause are recorded and explained; default 3",
    )
    how = campaign.add_argument_group("how it is run")
    how.add_argument("-j", "--workers", type=number(COUNT), default=1, metavar="N", help="trials at a time; default 1")
    how.add_argument(
        "--cluster",
        metavar="ADDRESS",
        help="run the trials on this Ray cluster, with the workspace shipped to it: auto, HOST:6379, ray://HOST:10001",
    )
    how.add_argument(
        "--time-limit",
        type=number(DURATION),
        metavar="S",
        help="time on the wall clock after which a trial hangs; default 5 min",
    )
    how.add_argument("--memory", type=size, metavar="SIZE", help="most memory of each worker, as 2GB; default: any")
    how.add_argument("--quiet", action="store_true", help="print only errors and the summary")
    how.add_argument("--json", action="store_true", help="for programs: print the summary, or the comparison, as JSON")
    add_workspace(campaign)
    _add_words(campaign)


def _add_words(campaign: Parser) -> None:
    """Declare what is done with campaigns that are over."""
    compare = campaign.add_word("compare", "A B", _COMPARE, _COMPARE_EXAMPLES)
    compare.add_argument("--out", type=Path, metavar="FILE", help="write the comparison there, as Markdown")
    compare.add_argument("--json", action="store_true", help="for programs: print the comparison as JSON")
    rerun = campaign.add_word("rerun", "DIR TRIAL", _RERUN, _RERUN_EXAMPLES)
    add_workspace(rerun)
