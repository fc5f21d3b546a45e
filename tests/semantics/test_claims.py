"""Every sentence of docs/semantics.md is a claim, and every claim is shown by a test."""

from __future__ import annotations

import importlib
import re
from collections import Counter
from pathlib import Path

import pytest

from tests.semantics.claims import PAGE, Piece, pieces

PIECES = pieces(PAGE.read_text(encoding="utf-8"))
LEADS = re.compile(r"(.*:|\[Checks\]\(checks\.md\) lists .*|What is said of py_trees is shown .*)")
"""Paragraphs that say where something stands, and nothing of what nodes do."""


def shown() -> set[str]:
    """Return the claims that the tests of this folder show."""
    found: set[str] = set()
    for path in Path(__file__).parent.glob("test_*.py"):
        module = importlib.import_module(f"tests.semantics.{path.stem}")
        for name, test in vars(module).items():
            if name.startswith("test_"):
                found.update(getattr(test, "shows", ()))
    return found


def test_every_claim_is_shown_and_nothing_else() -> None:
    claimed = {claim for piece in PIECES for claim in piece.claims}
    assert sorted(claimed - shown()) == [], "no test shows these claims"
    assert sorted(shown() - claimed) == [], "the page has no such claims"


WHOLE = {"test_claims", "test_model", "test_properties", "test_results"}
"""Modules that are about the page as a whole."""


def test_every_test_shows_a_claim() -> None:
    for path in Path(__file__).parent.glob("test_*.py"):
        module = importlib.import_module(f"tests.semantics.{path.stem}")
        if path.stem not in WHOLE:
            idle = [
                name for name, test in vars(module).items() if name.startswith("test_") and not vars(test).get("shows")
            ]
            assert idle == []


@pytest.mark.parametrize("piece", PIECES, ids=lambda piece: str(piece.line))
def test_every_sentence_is_one_claim(piece: Piece) -> None:
    if piece.kind == "paragraph":
        assert LEADS.fullmatch(piece.text)
    else:
        assert len(piece.claims) == 1
    if piece.kind == "item":
        assert re.search(r"[.?!] +[A-Z`]", piece.text) is None, "two sentences"
        assert piece.text.endswith(".")


def test_a_claim_stands_once() -> None:
    counted = Counter(claim for piece in PIECES for claim in piece.claims)
    assert [claim for claim, count in counted.items() if count > 1] == []


def test_a_sentence_without_an_id_is_found() -> None:
    items = "- One. <!-- claim: one -->\n- Two,\n  folded.\n"
    page = f"# T\n\nIntro.\n\n## S\n\n{items}\nA paragraph.\n\n| a |\n| --- |\n| b |\n"
    found = [(piece.kind, piece.text, piece.claims) for piece in pieces(page)]
    assert found == [
        ("item", "One.", ("one",)),
        ("item", "Two, folded.", ()),
        ("paragraph", "A paragraph.", ()),
        ("row", "| b |", ()),
    ]
