"""docs/manifest.md and its schema are current, and what the page shows works."""

import functools
import json
import operator
import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest

from poisson_cli.batch import checking, grammar, manifest
from tests.batch_jobs import environment
from tests.test_batch_manifest import SAME, SELECTIONS

ROOT = Path(__file__).resolve().parent.parent
PAGE = (ROOT / "docs" / "manifest.md").read_text(encoding="utf-8")
SCHEMA = json.loads((ROOT / "docs" / "manifest.schema.json").read_text(encoding="utf-8"))


def fits(value, schema) -> bool:
    """As much of JSON Schema as the schema uses."""
    kinds = {
        "string": str, "number": (int, float), "integer": int, "boolean": bool, "null": type(None), "array": list,
        "object": dict,
    }  # fmt: skip
    if "$ref" in schema:
        return fits(value, functools.reduce(operator.getitem, schema["$ref"].split("/")[1:], SCHEMA))
    if "anyOf" in schema and not any(fits(value, one) for one in schema["anyOf"]):
        return False
    if "enum" in schema and value not in schema["enum"]:
        return False
    if "const" in schema and value != schema["const"]:
        return False
    if "type" in schema:
        names = schema["type"] if isinstance(schema["type"], list) else [schema["type"]]
        boolean = isinstance(value, bool) and "boolean" not in names
        if boolean or not isinstance(value, tuple(kinds[name] for name in names if name)):
            return False
    if isinstance(value, list):
        length = schema.get("minItems", 0) <= len(value) <= schema.get("maxItems", len(value))
        return length and all(fits(item, schema.get("items", {})) for item in value)
    if isinstance(value, dict):
        known = schema.get("properties", {})
        return (
            all(name in value for name in schema.get("required", []))
            and (schema.get("additionalProperties", True) or value.keys() <= known.keys())
            and all(fits(inner, known[name]) for name, inner in value.items() if name in known)
        )
    return True


def test_the_schema_and_the_table_are_current():
    ran = subprocess.run(
        [sys.executable, ROOT / "tools" / "manifest_schema.py", "--check"],
        env=environment(),
        capture_output=True,
        text=True,
    )
    assert (ran.returncode, ran.stdout, ran.stderr) == (0, "", "")
    assert SCHEMA["$defs"].keys() == {"defaults", "options", "selection", *grammar.tools()}


@pytest.mark.parametrize(
    "line", [*SAME.values(), *({"tool": "fill", "image": "a", "output": "o", **s} for s in SELECTIONS)]
)
def test_lines_that_are_right_fit_the_schema(line):
    plain = {name.replace("-", "_"): value for name, value in line.items()}
    assert fits(plain, SCHEMA)
    assert not fits({**plain, "colour": 3}, SCHEMA)
    assert not fits({name: value for name, value in plain.items() if name != "output"}, SCHEMA)
    assert not fits({**plain, "rect": [1, 2, 3]}, SCHEMA)


@pytest.mark.parametrize("kind", ["json", "csv"])
def test_the_manifests_on_the_page(kind):
    (text,) = re.findall(rf"```{kind}\n(.*?)```", PAGE, re.DOTALL)
    tasks = checking.check(manifest.parse(text.encode()), make_folders=True)
    assert len(tasks) == (3 if kind == "json" else 2)
    if kind == "json":
        assert all(fits(json.loads(line), SCHEMA) for line in text.splitlines()[1:] if "mask" in line)


def test_the_manifest_from_folders(tmp_path):
    (tmp_path / "masks").mkdir()
    for name in ("b.png", "a.png"):
        (tmp_path / "masks" / name).write_bytes(b"")
    (text,) = re.findall(r"```sh\n(python -c.*?) > jobs.jsonl\n```", PAGE, re.DOTALL)
    words = [sys.executable, *shlex.split(text)[1:]]
    out = subprocess.run(words, cwd=tmp_path, capture_output=True, check=True).stdout
    first, second = checking.check(manifest.parse(out), make_folders=True)
    assert [str(path) for path in (*first.outputs, *second.outputs)] == ["out/a.png", "out/b.png"]
    assert first.jobs[0].source == Path("src/a.png")
