"""Reference pages of the scene document and of the HTTP routes, as Markdown, from their JSON schemas."""

import json
from collections.abc import Iterator
from typing import Any

Schema = dict[str, Any]
LONG_CELL = 300  # characters


def scene_page(schema: Schema) -> str:
    """Members of a scene document, and of each object in it, from the schema of its model."""
    definitions = schema["$defs"]
    kinds = Kinds(definitions)
    effects = schema["properties"]["effects"]["items"]["oneOf"]
    effects = [definitions[name_of(effect)] if "$ref" in effect else effect for effect in effects]
    lines = ["# Members of a scene", *section("## Scene", schema, kinds)]
    lines += ["## Effects", "Each member of the list `effects` is one of these."]
    for effect in sorted(effects, key=lambda effect: effect["properties"]["type"]["const"]):
        lines += section(f"### {effect['properties']['type']['const']}", effect, kinds)
    lines += ["## Parts", "Objects that the tables above name."]
    return "\n\n".join([*lines, *kinds.sections()]) + "\n"


def http_page(description: Schema, scene: Schema) -> str:
    """Routes with their parameters, bodies and answers, from the service's OpenAPI description."""
    definitions = description["components"]["schemas"]
    kinds = Kinds(definitions, elsewhere=dict.fromkeys([*scene["$defs"], "Scene"], "scene.md"))
    lines = [
        "# Routes of the service",
        f"A request that fails is answered by a {kinds.reference('Problem')}.",
    ]
    headers: Schema = {}
    for path, methods in description["paths"].items():
        for method, route in methods.items():
            lines += [f"## {method.upper()} {path}", route["description"], *parts(route, kinds)]
            for response in route["responses"].values():
                headers |= response.get("headers", {})
    rows = [[f"`{name}`", header.get("description", "")] for name, header in headers.items()]
    lines += ["## Headers of answers", table(["header", "meaning"], rows)]
    lines += ["## Parts", "Objects that the tables above name."]
    return "\n\n".join([*lines, *kinds.sections()]) + "\n"


class Kinds:
    """The kind of a member in words, with links to the sections of the objects that it names."""

    def __init__(self, definitions: Schema, elsewhere: dict[str, str] | None = None) -> None:
        self.definitions, self.elsewhere = definitions, elsewhere or {}
        self.named: list[str] = []

    def sections(self) -> Iterator[str]:
        """Sections of all objects that were named, and of those that these name."""
        for name in self.named:  # grows meanwhile
            yield from section(f"### {name}", self.definitions[name], self)

    def text(self, schema: Schema) -> str:
        choices = schema.get("anyOf", schema.get("oneOf"))
        if choices:
            texts = [self.text(choice) for choice in choices if choice.get("type") != "null"]
            return " or ".join(dict.fromkeys(texts)) + example(schema)
        if "$ref" in schema:
            return self.reference(name_of(schema))
        if "const" in schema or "enum" in schema:
            return ", ".join(f"`{json.dumps(value)}`" for value in schema.get("enum", [schema.get("const")]))
        if schema.get("type") == "array":
            return self.array(schema)
        if "properties" in schema:
            return "`{" + ", ".join(f'"{name}"' for name in schema["properties"]) + "}`"
        return scalar(schema)

    def reference(self, name: str) -> str:
        properties = self.definitions[name].get("properties", {})
        if set(properties) == {"value", "unit"}:
            unit = properties["unit"].get("examples", [""])[0]
            return f"{self.text(properties['value'])} with a unit such as `{unit}`: `{{value, unit}}`"
        page = self.elsewhere.get(name, "")
        if not page and name not in self.named:
            self.named.append(name)
        return f"[{name}]({page}#{name.lower()})"

    def array(self, schema: Schema) -> str:
        items, count = schema.get("items", {}), schema.get("minItems")
        if count is not None and count == schema.get("maxItems"):
            return f"{count} x {items['minItems']} numbers" if "minItems" in items else f"{count} numbers"
        return f"list of {self.text(items)}" if items else "list"


def scalar(schema: Schema) -> str:
    kind = schema.get("type", "anything")
    text = {"string": "text", "boolean": "true or false"}.get(kind, kind)
    if schema.get("format") == "binary":
        return "content of a file"
    for key, word in (("exclusiveMinimum", "above"), ("minimum", "at least"), ("maximum", "at most")):
        if key in schema:
            text += f", {word} {schema[key]:g}"
    return text + example(schema)


def example(schema: Schema) -> str:
    return f", such as `{schema['examples'][0]}`" if schema.get("examples") else ""


def section(heading: str, schema: Schema, kinds: Kinds) -> Iterator[str]:
    yield heading
    if "description" in schema:
        yield schema["description"]
    if "properties" in schema:
        yield members(schema, kinds)


def members(schema: Schema, kinds: Kinds) -> str:
    required = {*schema.get("required", []), *schema.get("then", {}).get("required", [])}
    rows = []
    for name, member in schema["properties"].items():
        default = member.get("default")
        need = "required" if name in required else "" if default in (None, "") else f"`{json.dumps(default)}`"
        is_any_effect = name == "effects" and "oneOf" in member.get("items", {})
        kind = "list of [effects](#effects)" if is_any_effect else kinds.text(member)
        rows.append([f"`{name}`", kind, need, member.get("description", "")])
    return table(["member", "kind", "default", "meaning"], rows)


def parts(route: Schema, kinds: Kinds) -> Iterator[str]:
    """Parameters, bodies and the answer of a route."""
    rows = [
        [f"`{value['name']}`", kinds.text(value["schema"]), value.get("description", "")]
        for value in route.get("parameters", [])
    ]
    if rows:
        yield table(["parameter", "kind", "meaning"], rows)
    for media, body in route.get("requestBody", {}).get("content", {}).items():
        is_object = "properties" in body["schema"]
        yield f"**Body**, `{media}`: " + ("an object" if is_object else kinds.text(body["schema"]))
        if is_object:
            yield from section("", body["schema"], kinds)
    answer = route["responses"]["200"]
    content = answer.get("content", {})
    kind = kinds.text(content.get("application/json", {}).get("schema", {"type": "text"}))
    meaning = answer["description"].replace("Successful Response", "")
    yield f"**Answer**: {kind}" + (f". {meaning}" if meaning else "")
    yield "Media types: " + ", ".join(f"`{name}`" for name in content) + "."


def table(head: list[str], rows: list[list[str]]) -> str:
    """Without the columns in which nothing stands; a long list in a cell has a line for each entry."""
    filled = [column for column in range(len(head)) if any(row[column] for row in rows)]
    lines = [[head[column] for column in filled], ["---"] * len(filled)]
    for row in rows:
        cells = [row[column].replace("|", "\\|").replace("\n", " ") for column in filled]
        lines.append([text.replace("; ", ";<br>") if len(text) > LONG_CELL else text for text in cells])
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)


def name_of(reference: Schema) -> str:
    return str(reference["$ref"].rpartition("/")[2])
