"""One vocabulary: every code that is raised is in it, and nothing else is."""

from __future__ import annotations

import ast
from pathlib import Path

from engine.diagnosis import VOCABULARY, Diagnosis, worth_saying

ROOT = Path(__file__).resolve().parents[1]


def raised() -> set[str]:
    """Codes that are written out where a diagnosis is made."""
    found = set()
    for path in [*ROOT.glob("engine/**/*.py"), *ROOT.glob("server/**/*.py")]:
        for node in ast.walk(ast.parse(path.read_text())):
            if isinstance(node, ast.Call) and ast.unparse(node.func) == "Diagnosis" and node.args:
                code = node.args[0]
                if isinstance(code, ast.Constant):
                    found.add(str(code.value))
    return found


def test_every_code_is_in_the_vocabulary_and_none_is_for_nothing() -> None:
    assert raised() == set(VOCABULARY)


def test_the_document_lists_the_vocabulary() -> None:
    text = (ROOT / "docs" / "warnings.md").read_text()
    rows = [line for line in text.splitlines() if line.startswith("| `")]
    assert rows == [
        f"| `{code}` | {entry.of} | {entry.meaning} | {entry.mend} |"
        for code, entry in VOCABULARY.items()
    ]


def test_what_is_below_the_budget_is_not_worth_saying() -> None:
    """What has no number always is."""
    said = [Diagnosis("opaque", "a", size) for size in (0.0, 0.04, 0.05, 0.06)]
    assert [d.size for d in worth_saying(said, 0.05)] == [0.0, 0.06]
