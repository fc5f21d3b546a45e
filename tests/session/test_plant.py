"""Where a plant in another process is, and its key: mistakes are told before anything starts."""

from __future__ import annotations

from pathlib import Path

import pytest

from humanoid_bt.cable.address import Address, read_address, read_key
from humanoid_bt.cli import main
from humanoid_bt.core.errors import UserError
from humanoid_bt.session.session import Session


@pytest.mark.parametrize(
    ("text", "address"),
    [
        ("udp://127.0.0.1:5000", Address("127.0.0.1", 5000)),
        ("127.0.0.1", Address("127.0.0.1", 4747)),
        ("[::1]:5000", Address("::1", 5000)),
        ("localhost:5000", Address("127.0.0.1", 5000)),
    ],
)
def test_an_address_is_read(text: str, address: Address) -> None:
    assert read_address(text) == address
    assert read_address(str(address)) == address


@pytest.mark.parametrize("text", ["", "udp://", "tcp://127.0.0.1:1", "127.0.0.1:99999", "127.0.0.1:x", "udp://a/b"])
def test_what_is_no_address_is_answered_with_what_one_is(text: str) -> None:
    with pytest.raises(UserError, match="valid: udp://HOST:PORT"):
        read_address(text)


def test_others_than_this_machine_need_a_key() -> None:
    assert read_key(Address("127.0.0.1", 1), None) is None
    assert read_key(Address("::1", 1), None) is None
    for host in ("0.0.0.0", "192.0.2.7", "::"):
        with pytest.raises(UserError, match="its frames need a key"):
            read_key(Address(host, 1), None)


@pytest.mark.parametrize(
    ("content", "mode", "why"),
    [(b"k" * 15, 0o600, "must have 16 to 4096 bytes"), (b"k" * 32, 0o640, "others than its owner can reach")],
)
def test_a_key_that_is_none_or_not_secret_is_refused(tmp_path: Path, content: bytes, mode: int, why: str) -> None:
    key = tmp_path / "plant.key"
    key.write_bytes(content)
    key.chmod(mode)
    with pytest.raises(UserError, match=why):
        read_key(Address("127.0.0.1", 1), key)


def test_a_good_key_is_read(tmp_path: Path) -> None:
    key = tmp_path / "plant.key"
    key.write_bytes(b"k" * 32)
    key.chmod(0o600)
    assert read_key(Address("192.0.2.7", 1), key) == b"k" * 32


def test_every_mistake_of_a_session_is_told_at_once() -> None:
    with pytest.raises(UserError) as caught:
        Session("stand", plant="udp://192.0.2.7:1", seed=-1)
    text = str(caught.value)
    assert "'plant' does not go with the mode lockstep" in text
    assert "its frames need a key" in text
    assert "'seed'" in text
    with pytest.raises(UserError, match="'plant_key' is that of a plant"):
        Session("stand", plant_key="plant.key")
    with pytest.raises(UserError, match="'plant' must be an address"):
        Session("stand", plant=7, mode="realtime")  # type: ignore[arg-type]  # the mistake that is tried


def test_the_commands_tell_it_too(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["run", "stand", "--plant", "udp://192.0.2.7"]) == 2
    assert main(["plant", "humanoid", "--listen", "0.0.0.0"]) == 2
    assert main(["plant", "humanoid", "--key", "missing.key"]) == 2
    told = capsys.readouterr().err
    assert told.count("its frames need a key") == 2
    assert "the key 'missing.key' cannot be read: No such file or directory" in told
