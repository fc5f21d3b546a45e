"""A recording as an MCAP file, which Foxglove and PlotJuggler open."""

from __future__ import annotations

import json
from pathlib import Path

from humanoid_bt.core.errors import UserError
from humanoid_bt.core.plain import plain
from humanoid_bt.review.export import Progress, Wanted, refuse_existing, replaced, told_failures
from humanoid_bt.review.mcap_schemas import schemas
from humanoid_bt.review.recording import Recording

_TOLD = 0.1  # s of the run between two reports on how far it is


def export_mcap(
    recording: Recording, file: Path, wanted: Wanted, *, force: bool = False, progress: Progress
) -> list[Path]:
    """Write a recording as an MCAP file; return it, as a list.

    Args:
        recording: which one.
        file: what is written.
        wanted: which part of the run, and how many samples a second.
        force: overwrite a file that is there.
        progress: is told how far it is.

    Raises:
        UserError: the package is missing, the file is there already or cannot be written, or the recording has no
            servo cycles.
    """
    try:
        from mcap.writer import Writer  # noqa: PLC0415  # an extra

        from humanoid_bt.review.mcap_messages import TOPICS, messages  # noqa: PLC0415  # needs one
    except ImportError as error:
        raise UserError("MCAP files need two packages", hint="pip install 'humanoid-bt[mcap]'") from error
    refuse_existing([file], force)
    with told_failures(file):
        file.parent.mkdir(parents=True, exist_ok=True)
        with replaced(file) as draft, draft.open("wb") as stream:
            writer = Writer(stream)
            writer.start(library="humanoid_bt")
            known = {
                name: writer.register_schema(name, "jsonschema", json.dumps(schema).encode())
                for name, schema in schemas(TOPICS, recording.setup["robot"]["joints"]).items()
            }
            channels: dict[str, int] = {}
            told = -_TOLD
            for message in messages(recording, wanted):
                if message.topic not in channels:
                    channels[message.topic] = writer.register_channel(message.topic, "json", known[message.schema])
                at = round(message.time * 1e9)
                writer.add_message(channels[message.topic], at, json.dumps(message.value).encode(), at)
                if message.time - told >= _TOLD:
                    told = message.time
                    progress("messages", told)
            setup = json.dumps(plain(recording.setup), indent=2).encode()
            writer.add_attachment(0, 0, "run.json", "application/json", setup)
            writer.add_metadata(
                "run", {"title": recording.title, "outcome": recording.outcome, "reason": recording.reason}
            )
            writer.finish()
    return [file]
