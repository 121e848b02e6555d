"""Write the JSON schema of a manifest's lines and the table of names in docs/manifest.md, or check both.

Both come from the options of the commands, which are what a batch reads a manifest by. Usage:
``python tools/manifest_schema.py [--check]``.
"""

from __future__ import annotations

import argparse
import functools
import json
import sys
from collections import defaultdict
from pathlib import Path
from typing import Any

import click

from poisson_cli import params
from poisson_cli.batch import grammar

DOCS = Path(__file__).resolve().parent.parent / "docs"
SCHEMA = DOCS / "manifest.schema.json"
PAGE = DOCS / "manifest.md"
START, END = "<!-- names -->\n", "<!-- end names -->\n"

LENGTHS = {params.POINT: 2, params.RECTANGLE: 4, params.ELLIPSE: 4, params.FACTORS: 3}
WHOLE = {params.POINT, params.RECTANGLE, params.ELLIPSE, params.COUNT, params.EIGHT_BIT}


def of_type(kind: click.ParamType) -> dict[str, Any]:
    """What one value may be."""
    if isinstance(kind, click.Choice):
        return {"enum": list(kind.choices)}
    number = {"type": "integer" if kind in WHOLE else "number"}
    between = params.separators(kind)
    if not between:
        return {"type": "string"} if params.is_file(kind) else {"type": [number["type"], "string"]}
    numbers: dict[str, Any] = {"type": "array", "items": number}
    if len(between) == 2:
        point = {"type": "array", "items": {"type": "number"}, "minItems": 2, "maxItems": 2}
        numbers = {"type": "array", "items": point, "minItems": 3}
    else:
        numbers |= {"minItems": LENGTHS[kind], "maxItems": LENGTHS[kind]}
    return {"anyOf": [{"type": "string"}, numbers]}


def of_parameter(parameter: click.Parameter) -> dict[str, Any]:
    """What a line may say under a name; null is as if it were not there."""
    if isinstance(parameter, click.Option) and parameter.is_flag:
        schema: dict[str, Any] = {"type": ["boolean", "null"]}
    else:
        one = of_type(parameter.type)
        several = [{"type": "array", "items": one}] if parameter.multiple or parameter.nargs == -1 else []
        nothing = [] if parameter.required else [{"type": "null"}]
        schema = {"anyOf": [one, *several, *nothing]} if several or nothing else one
    if isinstance(parameter, click.Option) and parameter.help:
        schema = {"description": parameter.help, **schema}
    return schema


def steps(tool: grammar.Tool) -> dict[str, Any]:
    """The steps of a selection."""

    def one(name: str) -> dict[str, Any]:
        value = of_type(tool.keys[name].type)
        return {
            "type": "object",
            "properties": {name: value},
            "required": [name],
            "additionalProperties": False,
        }

    areas = {"anyOf": [one(name) for name in ("mask", "rect", "ellipse", "polygon", "lasso")]}
    combined = [
        {"type": "object", "properties": {how: areas}, "required": [how], "additionalProperties": False}
        for how in ("add", "subtract", "intersect")
    ]
    step = {"anyOf": [*areas["anyOf"], *combined, one("grow"), one("shrink")]}
    return {"description": "Steps of a selection, done in their order.", "type": "array", "items": step}


@functools.cache
def shared() -> dict[str, Any]:
    """What may be said under a name of which several tools say the same."""
    found: dict[str, list[dict[str, Any]]] = defaultdict(list)
    for tool in grammar.tools().values():
        for name, parameter in tool.keys.items():
            found[name].append(of_parameter(parameter))
    return {name: one[0] for name, one in found.items() if one.count(one[0]) > 1}


def of_tool(tool: grammar.Tool) -> dict[str, Any]:
    """A line for one tool."""
    properties = {"tool": {"const": tool.name}}
    for name, parameter in tool.keys.items():
        own = of_parameter(parameter)
        properties[name] = {"$ref": f"#/$defs/options/{name}"} if own == shared().get(name) else own
    if tool.selects:
        properties[grammar.SELECTION] = {"$ref": "#/$defs/selection"}
    required = ["tool", *(name for name, parameter in tool.keys.items() if parameter.required)]
    return {
        "title": tool.name,
        "description": tool.command.get_short_help_str(200),
        "type": "object",
        "properties": properties,
        "required": required,
        "additionalProperties": False,
    }


def schema() -> str:
    """The schema of a line, as text."""
    tools = grammar.tools()
    first = {
        "type": "object",
        "properties": {"defaults": {"type": "object"}},
        "required": ["defaults"],
        "additionalProperties": False,
    }
    document = {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "A line of a manifest of poisson batch",
        "anyOf": [{"$ref": f"#/$defs/{name}"} for name in ("defaults", *tools)],
        "$defs": {
            "defaults": {"description": "The first line may say this for all others.", **first},
            "options": shared(),
            "selection": steps(tools["mask"]),
            **{name: of_tool(tool) for name, tool in tools.items()},
        },
    }
    return json.dumps(document, indent=1) + "\n"


def table() -> str:
    """For each tool, the names that a line must have, and those that it may have."""
    rows = ["| tool | must have | may have |", "|---|---|---|"]
    for name, tool in grammar.tools().items():
        must = [key for key, parameter in tool.keys.items() if parameter.required]
        may = [key for key in tool.keys if key not in must]
        may += [grammar.SELECTION] if tool.selects else []
        rows.append(f"| `{name}` | {_listed(must)} | {_listed(may)} |")
    return "\n".join(rows) + "\n"


def _listed(names: list[str]) -> str:
    return ", ".join(f"`{name}`" for name in names)


def page(old: str) -> str:
    """The page with a current table."""
    before, rest = old.split(START)
    return f"{before}{START}{table()}{END}{rest.split(END)[1]}"


def main() -> int:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--check", action="store_true", help="write nothing; fail if a file is out of date")
    check = parser.parse_args().check
    current = {SCHEMA: schema(), PAGE: page(PAGE.read_text(encoding="utf-8"))}
    stale = [path for path, text in current.items() if not path.exists() or path.read_text("utf-8") != text]
    for path in stale:
        if check:
            print(f"{path.name} is out of date: run python tools/manifest_schema.py")
        else:
            path.write_text(current[path], encoding="utf-8")
            print(f"{path.name}: brought up to date")
    return int(check and bool(stale))


if __name__ == "__main__":
    sys.exit(main())
