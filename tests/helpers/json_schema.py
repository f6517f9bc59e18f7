"""A judge of data by JSON Schema: the keywords that the schemas of scenes use, and no others."""

_TYPES = {
    "object": dict,
    "array": list,
    "string": str,
    "boolean": bool,
    "integer": int,
    "number": (int, float),
}
_WORDS = {"$defs", "$ref", "$schema", "default", "description", "discriminator", "title"}
"""Keywords that judge nothing, or are followed."""


def complaints(value, node, root, place=""):
    """What is wrong with a value by a schema, each with its place."""
    while "$ref" in node:
        node = root["$defs"][node["$ref"].rpartition("/")[2]]
    for keyword, rule in node.items():
        if keyword not in _WORDS:
            yield from _RULES[keyword](value, rule, node, root, place)


def _type(value, rule, node, root, place):
    right = isinstance(value, _TYPES[rule])
    if not right or (isinstance(value, bool) and rule in ("integer", "number")):
        yield f"{place}: {value!r} is no {rule}"


def _properties(value, rule, node, root, place):
    for name, part in rule.items():
        if isinstance(value, dict) and name in value:
            yield from complaints(value[name], part, root, f"{place}.{name}")


def _others(value, rule, node, root, place):
    for name in set(value if isinstance(value, dict) else ()) - set(node.get("properties", {})):
        if rule is False:
            yield f"{place}.{name}: no such field"
        elif rule is not True:
            yield from complaints(value[name], rule, root, f"{place}.{name}")


def _required(value, rule, node, root, place):
    if isinstance(value, dict):
        yield from (f"{place}.{name}: missing" for name in rule if name not in value)


def _any_of(value, rule, node, root, place):
    if all(list(complaints(value, form, root, place)) for form in rule):
        yield f"{place}: {value!r} is none of {len(rule)} forms"


def _one_of(value, rule, node, root, place):
    if sum(not list(complaints(value, form, root, place)) for form in rule) != 1:
        yield f"{place}: {value!r} is not one of {len(rule)} forms"


def _items(value, rule, node, root, place):
    first = len(node.get("prefixItems", ()))
    for i, part in enumerate(value[first:] if isinstance(value, list) else (), first):
        yield from complaints(part, rule, root, f"{place}[{i}]")


def _prefix(value, rule, node, root, place):
    for i, (part, each) in enumerate(zip(value if isinstance(value, list) else (), rule)):  # noqa: B905
        yield from complaints(part, each, root, f"{place}[{i}]")


def _bound(fits):
    def judge(value, rule, node, root, place):
        if isinstance(value, int | float | list) and not fits(value, rule):
            yield f"{place}: {value!r} against {rule}"

    return judge


_RULES = {
    "type": _type,
    "properties": _properties,
    "additionalProperties": _others,
    "required": _required,
    "anyOf": _any_of,
    "oneOf": _one_of,
    "items": _items,
    "prefixItems": _prefix,
    "enum": lambda value, rule, *_: [] if value in rule else [f"{value!r} is not in {rule}"],
    "const": lambda value, rule, *_: [] if value == rule else [f"{value!r} is not {rule!r}"],
    "minimum": _bound(lambda value, rule: value >= rule),
    "maximum": _bound(lambda value, rule: value <= rule),
    "exclusiveMinimum": _bound(lambda value, rule: value > rule),
    "exclusiveMaximum": _bound(lambda value, rule: value < rule),
    "minItems": _bound(lambda value, rule: len(value) >= rule),
    "maxItems": _bound(lambda value, rule: len(value) <= rule),
}
