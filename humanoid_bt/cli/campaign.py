"""``humanoid-bt campaign``: a tree run many times, two campaigns compared, one trial run again."""

from __future__ import annotations

import argparse
import json
import shlex
import signal
import sys
import time
from collections.abc import Iterator, Sequence
from contextlib import closing, contextmanager
from pathlib import Path
from types import FrameType
from typing import NoReturn

from humanoid_bt.campaign.conduct import Runners, conduct, summary
from humanoid_bt.campaign.plan import Plan
from humanoid_bt.campaign.planning import Planned, planned
from humanoid_bt.campaign.report_html import html
from humanoid_bt.campaign.report_markdown import markdown
from humanoid_bt.campaign.requirement import Verdict
from humanoid_bt.campaign.stage_trials import Setup, make
from humanoid_bt.campaign.statistics import Rate
from humanoid_bt.campaign.store import Store
from humanoid_bt.campaign.summary import Summary
from humanoid_bt.campaign.unchanged import Unchanged
from humanoid_bt.campaign.words import counts, figures, headline, told
from humanoid_bt.campaign.workers import Workers
from humanoid_bt.cli.campaign_given import campaign_given, is_named, workspace_given
from humanoid_bt.cli.campaign_progress import CampaignProgress, duration
from humanoid_bt.cli.console import SafeConsole
from humanoid_bt.cli.output import hanging, print_lines
from humanoid_bt.core.errors import HumanoidBtError, UserError, relative
from humanoid_bt.files.workspace import Workspace
from humanoid_bt.session.options import RUNS
from humanoid_bt.session.report import ExitCode, aligned

_NOT_MET = 1
_CAUSES = 6  # that are told on the screen
_WORDS = {"compare": ("A", "B"), "rerun": ("DIR", "TRIAL")}  # what follows them


def campaign(arguments: argparse.Namespace) -> int:
    """Run a campaign, or do with one what the first word says; return the exit code."""
    word, *rest = arguments.what
    if word in _WORDS and (rest or not is_named(word, workspace_given(arguments))):
        if len(rest) != len(_WORDS[word]):
            message = f"campaign {word} takes {len(_WORDS[word])} arguments, not {len(rest)}"
            raise UserError(message, hint=" ".join(("humanoid-bt campaign", word, *_WORDS[word])))
        from humanoid_bt.cli import campaign_after

        return campaign_after.compare(arguments) if word == "compare" else campaign_after.rerun(arguments)
    if rest:
        raise UserError(
            f"one campaign at a time, not {len(rest) + 1}", hint="several trees: in a campaign file, tree: [a, b]"
        )
    return _run(arguments)


def _run(arguments: argparse.Namespace) -> int:
    workspace = workspace_given(arguments)
    if arguments.out is not None:
        arguments.out = Path(arguments.out).absolute()  # wherever skills go
    given, script = campaign_given(arguments, workspace)
    found = planned(given, workspace, script)
    folder = _folder(arguments, found.plan)
    console = SafeConsole(stderr=arguments.json)
    with Store(folder, found.plan, arguments.resume) as store:
        if arguments.resume and not store.results:
            print(f"no trial of it is done in {relative(folder)}: it begins anew", file=sys.stderr)
        if not arguments.quiet:
            console.print(f"{found.plan.name}: {found.plan.title}: {len(found.plan)} trials", soft_wrap=True)
        began, interrupted = time.monotonic(), False
        try:
            try:
                with (
                    closing(_runners(arguments, given.time_limit, found, store, workspace)) as runners,
                    _interruptions(),
                    _progress(console, arguments, store) as progress,
                ):
                    conduct(store, runners, given.recordings, progress)
            except KeyboardInterrupt:
                interrupted = True
            code = _told(console, arguments, found, store, time.monotonic() - began)
        except HumanoidBtError:
            _kept(store, "not done")
            raise
        if interrupted:
            _kept(store, "interrupted")
    return ExitCode.INTERRUPTED if interrupted else code


def _runners(
    arguments: argparse.Namespace, time_limit: float, found: Planned, store: Store, workspace: Workspace
) -> Runners:
    """Return who runs the trials: processes of this machine, or those of a cluster."""
    plan, memory = found.plan, arguments.memory
    if arguments.cluster is not None:
        from humanoid_bt.campaign.ray_cluster import RayCluster, Ways, see_that_it_is_shipped

        see_that_it_is_shipped(plan, workspace)
        return RayCluster(arguments.cluster, workspace.root, Ways(make, (Setup.of(plan, "."),), time_limit, memory))
    setup = (Setup.of(plan, str(workspace.root)),)
    workers = Workers(make, setup, count=arguments.workers, time_limit=time_limit, memory=memory, logs=store.logs)
    return Unchanged(workers, found.files, plan.files)  # a cluster has been shipped all of them


def _progress(console: SafeConsole, arguments: argparse.Namespace, store: Store) -> CampaignProgress:
    before = store.results.values()
    good = Rate(sum(result.succeeded for result in before), len(before))
    return CampaignProgress(console, len(store.plan), good, arguments.quiet)


def _folder(arguments: argparse.Namespace, plan: Plan) -> Path:
    if arguments.out is not None:
        return Path(arguments.out)
    if arguments.resume:
        raise UserError("--resume needs the folder of the campaign", hint="--out DIR, as it was told when it began")
    return RUNS / f"campaign-{plan.name.replace(' ', '-')}-{time.strftime('%Y%m%d-%H%M%S')}"


def _told(console: SafeConsole, arguments: argparse.Namespace, found: Planned, store: Store, took: float) -> int:
    """Write the reports of what is done, print what they say; return the exit code."""
    said = summary(store)
    verdicts = [requirement.judge(said) for requirement in found.requirements]
    plain = json.dumps({**said.to_dict(), "required": {one.text: one.met for one in verdicts}}, indent=1)
    store.write("summary.json", f"{plain}\n".encode())
    store.write("report.md", markdown(said, verdicts, store.folder).encode())
    store.write("report.html", html(said, verdicts, store.folder).encode())
    if arguments.json:
        print(plain)
    else:
        _print(console, said, verdicts, store, took)
    for one in verdicts:
        if not one.met:
            print(f"not met: {one.text}: {one.why}", file=sys.stderr)
    if said.done and said.without_result == said.done:
        print(f"no trial came to a result: {', '.join(counts(said))}", file=sys.stderr)
        return ExitCode.ERROR
    return ExitCode.SUCCESS if all(one.met for one in verdicts) else _NOT_MET


def _print(console: SafeConsole, said: Summary, verdicts: Sequence[Verdict], store: Store, took: float) -> None:
    console.print(headline(said), style="bold", soft_wrap=True)
    rows = [("took", f"{duration(took)}; {store.share_simulating:.0%} of the workers' time simulated"), *figures(said)]
    rows += [("met", f"{one.text} ({one.why})") for one in verdicts if one.met]
    rows += [("report", str(Path(relative(store.folder)) / "report.html"))]
    print_lines(aligned(rows))
    for cause in said.causes[:_CAUSES]:
        first, *more, again = told(cause, said, store.folder)
        print()
        print_lines(hanging("  ", first))
        for text in more:
            print_lines(hanging("    ", text))
        print(f"    {again}")  # to be copied: not broken
    if (left := len(said.causes) - _CAUSES) > 0:
        print(f"\n  and {left} more causes in the report")


def _kept(store: Store, why: str) -> None:
    """Say what is kept of a campaign that is not done."""
    if done := len(store.results):
        kept = f"{done} of {len(store.plan)} trials are kept"
        more = shlex.join(["--out", relative(store.folder), "--resume"])
        print(f"{why}: {kept}; the same command with {more} goes on", file=sys.stderr)


@contextmanager
def _interruptions() -> Iterator[None]:
    """Let what ends programs end a campaign as Ctrl-C does."""

    def end(_number: int, _frame: FrameType | None) -> NoReturn:
        raise KeyboardInterrupt

    ignored = signal.getsignal(signal.SIGHUP) is signal.SIG_IGN  # nohup
    before = {number: signal.signal(number, end) for number in (signal.SIGTERM, *([] if ignored else [signal.SIGHUP]))}
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
