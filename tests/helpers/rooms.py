"""Who imports whom, read from the source: modules, folders, packages, and circles among them."""

import ast
from collections.abc import Iterable, Iterator, Mapping
from functools import cache
from graphlib import CycleError, TopologicalSorter
from pathlib import Path


def modules_in(root: Path, packages: Iterable[str]) -> dict[str, Path]:
    """Files of packages below a root, by the name they are imported under."""
    return {
        ".".join(file.relative_to(root).with_suffix("").parts).removesuffix(".__init__"): file
        for package in packages
        for file in sorted((root / package).rglob("*.py"))
    }


@cache
def imported_names(file: Path, module: str, *, at_once: bool = False) -> frozenset[str]:
    """Every name that a file imports, wherever in it: in functions and for type checking too.

    ``from a import b`` gives ``a.b``: b may be a module. Relative imports are made absolute.

    Parameters
    ----------
    file, module
        The file, and the name it is imported under.
    at_once
        Whether only what is imported as the file itself is imported: not what stands in functions
        or below ``if TYPE_CHECKING``.
    """
    tree = ast.parse(file.read_text(encoding="utf-8"))
    package = module if file.name == "__init__.py" else module.rpartition(".")[0]
    nodes = _run_at_once(tree) if at_once else ast.walk(tree)
    return frozenset(name for node in nodes for name in _names(node, package))


def _names(node: ast.AST, package: str) -> Iterator[str]:
    """What a statement in a package imports."""
    if isinstance(node, ast.Import):
        yield from (alias.name for alias in node.names)
    elif isinstance(node, ast.ImportFrom):
        base = node.module or ""
        if node.level:
            parts = package.split(".")
            above = parts[: len(parts) - node.level + 1]
            base = ".".join([*above, base] if base else above)
        yield from (f"{base}.{alias.name}" for alias in node.names)


def _run_at_once(node: ast.AST) -> Iterator[ast.AST]:
    """Nodes below one that run as their file is imported."""
    for child in ast.iter_child_nodes(node):
        later = isinstance(child, ast.FunctionDef | ast.AsyncFunctionDef | ast.Lambda)
        typing = isinstance(child, ast.If) and "TYPE_CHECKING" in ast.unparse(child.test)
        if not later and not typing:
            yield child
            yield from _run_at_once(child)


def imports_within(modules: Mapping[str, Path], *, at_once: bool = False) -> dict[str, set[str]]:
    """For each module, those of the same mapping that it imports."""

    def named(name: str) -> str | None:
        """The longest beginning of a name that is a module."""
        while name and name not in modules:
            name = name.rpartition(".")[0]
        return name or None

    return {
        module: {
            found
            for name in imported_names(file, module, at_once=at_once)
            if (found := named(name))
        }
        - {module}
        for module, file in modules.items()
    }


def imports_of_others(modules: Mapping[str, Path]) -> dict[str, set[str]]:
    """For each module, the top-level packages that it imports."""
    return {
        module: {name.partition(".")[0] for name in imported_names(file, module)}
        for module, file in modules.items()
    }


def folder_of(module: str, modules: Mapping[str, Path]) -> str:
    """The folder of a module, as a dotted name; a package's ``__init__`` belongs to its folder."""
    file = modules[module]
    return module if file.name == "__init__.py" else module.rpartition(".")[0]


def imports_between_folders(modules: Mapping[str, Path]) -> dict[str, set[str]]:
    """For each folder, the other folders that files in it import from."""
    folders: dict[str, set[str]] = {}
    for module, imported in imports_within(modules).items():
        here = folder_of(module, modules)
        there = {folder_of(name, modules) for name in imported}
        folders.setdefault(here, set()).update(there - {here})
    return folders


def circles(graph: Mapping[str, set[str]]) -> list[str]:
    """Names along a circle of a graph, the first one again at the end; none where there is none."""
    try:
        TopologicalSorter(graph).prepare()
    except CycleError as error:
        return list(error.args[1])
    return []
