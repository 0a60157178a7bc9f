# SPDX-License-Identifier: GPL-2.0-or-later
"""The modules of the Python package import each other in one direction."""

import ast
from pathlib import Path

package = Path(__file__).resolve().parents[2] / "scripts" / "talik"


def nameOf(path):
	"""talik/studies/accuracy/neumann.py as talik.studies.accuracy.neumann; a folder as its __init__.py."""
	parts = path.relative_to(package.parent).with_suffix("").parts
	return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


def imported(path, names):
	"""Modules among names that a module imports anywhere, in functions too. A name that a package gives is taken for its module."""
	module = nameOf(path)
	home = module if path.name == "__init__.py" else module.rpartition(".")[0]
	found = set()
	for node in ast.walk(ast.parse(path.read_text(), str(path))):
		if isinstance(node, ast.Import):
			found.update(alias.name for alias in node.names)
		elif isinstance(node, ast.ImportFrom):
			base = node.module or ""
			if node.level:
				up = home.split(".")[: len(home.split(".")) - node.level + 1]
				base = ".".join([*up, *([node.module] if node.module else [])])
			found.update(f"{base}.{alias.name}" if f"{base}.{alias.name}" in names else base for alias in node.names)
		elif isinstance(node, ast.Attribute):
			found.add(ast.unparse(node))  # loaded when it is first used
	return {name for name in found if name in names} - {module}


def cycles(graph):
	"""Lists of modules that reach themselves, the shortest way from each."""
	found = []
	for start in sorted(graph):
		ways = [[start]]
		seen = set()
		while ways:
			way = ways.pop(0)
			if start in graph[way[-1]]:
				found.append([*way, start])
				break
			for following in sorted(graph[way[-1]] - seen):
				seen.add(following)
				ways.append([*way, following])
	return found


def graphOfPackage():
	paths = {nameOf(path): path for path in package.rglob("*.py")}
	graph = {name: imported(path, set(paths)) for name, path in paths.items()}
	# the package gives names of its modules, which it loads when they are asked for; to import it is no dependence on them
	return {name: uses - {"talik"} if name != "talik" else set() for name, uses in graph.items()}


def test_circles_are_seen(tmp_path):
	assert cycles({"a": {"b"}, "b": {"c"}, "c": set()}) == []
	assert cycles({"a": {"b"}, "b": {"c"}, "c": {"b"}}) == [["b", "c", "b"], ["c", "b", "c"]]


def test_modules_of_the_package_import_each_other_without_circles():
	graph = graphOfPackage()
	found = cycles(graph)
	print(f"{len(graph)} modules, {sum(map(len, graph.values()))} imports among them, {len(found)} modules on circles")
	assert not found, "\n".join(" -> ".join(way) for way in found)


def test_tools_for_scenes_know_no_studies_and_guards_know_no_tools():
	graph = graphOfPackage()
	tools = [name for name in graph if not name.startswith(("talik.studies", "talik.guards"))]
	upward = {(name, used) for name in tools for used in graph[name] if used.startswith("talik.studies")}
	known = {"talik._talik", "talik.ranks", "talik.files"}
	fromGuards = {(name, used) for name in graph if name.startswith("talik.guards") for used in graph[name] - known if not used.startswith("talik.guards")}
	print(f"{len(tools)} tools import {len(upward)} studies; guards import {len(fromGuards)} tools beside {', '.join(sorted(known))}")
	assert not upward | fromGuards, sorted(upward | fromGuards)
