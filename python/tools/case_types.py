"""Writes python/canopy_fem/case_types.py, the types of a case, from the schema of the installed module.

python python/tools/case_types.py
"""

from __future__ import annotations

import keyword
import textwrap
from pathlib import Path
from typing import Any

TARGET = Path(__file__).resolve().parents[1] / "canopy_fem" / "case_types.py"

HEAD = '''"""Types of a case as a dictionary, for checkers such as mypy and pyright.

python/tools/case_types.py makes them of the schema.

No key is required, since other values may come by path (`Case(source, overrides)`). Arrays of numpy stand for lists,
paths for texts, and a mesh for the section `mesh`.
"""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from typing import Any, Literal, TypeAlias, TypedDict

import numpy.typing as npt

from ._core import Mesh

__all__ = ["CaseDict"]

Text: TypeAlias = "str | os.PathLike[str]"
Numbers: TypeAlias = "Sequence[float] | npt.NDArray[Any]"
'''


class Types:
    """The types of a schema; those of parts without a name are called after where they are."""

    def __init__(self, schema: dict[str, Any]) -> None:
        self.schema = schema
        self.made: dict[str, str] = {}

    def text(self) -> str:
        self.define("CaseDict", self.schema)
        for name, part in self.schema.get("$defs", {}).items():
            self.define(name, part)
        return HEAD + "".join(f"\n\n{text}\n" for text in self.made.values())

    def define(self, name: str, part: dict[str, Any]) -> None:
        if "properties" in part and not any(key in part for key in ("oneOf", "anyOf", "allOf")):
            self.object(name, part)
        else:
            self.made[name] = ""  # its place, before those of its parts
            self.made[name] = f"{name}: TypeAlias = {quoted(self.type(part, name))}{doc(part)}"

    def object(self, name: str, part: dict[str, Any]) -> None:
        self.made[name] = ""
        entries = {key: self.type(of, name + camel(key)) for key, of in part["properties"].items()}
        if name.endswith("Network") and "mesh" in entries:
            entries["mesh"] += " | Mesh"
        if all(key.isidentifier() and not keyword.iskeyword(key) for key in entries):
            lines = "".join(f"    {key}: {kind}\n" for key, kind in entries.items()) or "    pass\n"
            told = summary(part)
            head = f'    """{told}"""\n\n' if told else ""
            self.made[name] = f"class {name}(TypedDict, total=False):\n{head}{lines}".rstrip()
        else:
            lines = "".join(f'    "{key}": {quoted(kind)},\n' for key, kind in entries.items())
            self.made[name] = f'{name} = TypedDict("{name}", {{\n{lines}}}, total=False){doc(part)}'

    def type(self, part: Any, name: str) -> str:
        if part is True or not part:
            return "Any"
        if "$ref" in part:
            return str(part["$ref"]).rsplit("/", 1)[1]
        if "const" in part:
            return f"Literal[{part['const']!r}]".replace("'", '"')
        if "enum" in part:
            return (
                "Literal["
                + ", ".join(f'"{value}"' if isinstance(value, str) else repr(value) for value in part["enum"])
                + "]"
            )
        for key in ("oneOf", "anyOf"):
            if key in part:
                return self.union(part[key], name)
        if "allOf" in part:
            return self.type(part["allOf"][0], name)
        kinds = part.get("type")
        if isinstance(kinds, list):
            return " | ".join(dict.fromkeys(self.type({**part, "type": kind}, name) for kind in kinds))
        if kinds == "object":
            return self.mapping(part, name)
        if kinds == "array":
            return self.array(part, name)
        return {"string": "Text", "number": "float", "integer": "int", "boolean": "bool", "null": "None"}.get(
            kinds, "Any"
        )

    def union(self, choices: list[dict[str, Any]], name: str) -> str:
        made = []
        for choice in choices:
            inner = choice.get("properties", {})
            made.append(self.type(choice, name + (camel(next(iter(inner))) if inner else "")))
        literals = [kind[8:-1] for kind in made if kind.startswith("Literal[")]
        others = [kind for kind in made if not kind.startswith("Literal[")]
        if literals:
            others.insert(0, f"Literal[{', '.join(literals)}]")
        return " | ".join(dict.fromkeys(others))

    def mapping(self, part: dict[str, Any], name: str) -> str:
        if "properties" in part:
            while name in self.made or name in self.schema.get("$defs", {}):
                name += "_"
            self.object(name, part)
            return name
        of = part.get("additionalProperties", True)
        return f"Mapping[str, {self.type(of, name) if isinstance(of, dict) else 'Any'}]"

    def array(self, part: dict[str, Any], name: str) -> str:
        items = part.get("items", part.get("prefixItems", [{}])[0] if part.get("prefixItems") else {})
        prefix = [self.type(of, name) for of in part.get("prefixItems", [])]
        inner = self.type(items, name) if isinstance(items, dict) else "Any"
        if prefix:
            inner = " | ".join(dict.fromkeys(prefix))
        if inner in ("float", "int"):
            return "Numbers"
        if inner == "Numbers":
            return "Sequence[Numbers] | npt.NDArray[Any]"
        return f"Sequence[{inner}]"


def camel(key: str) -> str:
    return "".join(word[:1].upper() + word[1:] for word in key.replace("$", "").replace("-", "_").split("_"))


def quoted(kind: str) -> str:
    return "'" + kind + "'" if '"' in kind else f'"{kind}"'


def summary(part: dict[str, Any]) -> str:
    told = str(part.get("description", "")).split("\n\n", 1)[0]
    text = " ".join(told.split()).replace("\\", "").replace('"', "'")
    return "\n    ".join(textwrap.wrap(text, 112))


def doc(part: dict[str, Any]) -> str:
    told = summary(part).replace("\n    ", "\n")
    return f'\n"""{told}"""' if told else ""


if __name__ == "__main__":
    import canopy_fem

    TARGET.write_text(Types(canopy_fem.schema()).text(), encoding="utf-8")
