"""What the repository's own files promise: pinned actions, lowest versions of extras, and one text of citation."""

import ast
import importlib
import json
import re
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest
import yaml

import roughxr

ROOT = Path(__file__).parents[1]

pytestmark = pytest.mark.skipif(not (ROOT / ".github").is_dir(), reason="not a checkout")


def test_actions_are_pinned_by_hash():
    workflows = sorted((ROOT / ".github" / "workflows").glob("*.yml"))
    actions = [line for path in workflows for line in path.read_text().splitlines() if "uses:" in line]
    assert len(actions) >= 7
    assert all(re.search(r"uses: \S+@[0-9a-f]{40}  # v\d", line) for line in actions)


def test_lowest_versions_cover_every_extra_of_users():
    run = subprocess.run([sys.executable, ".ci/lowest"], cwd=ROOT, check=True, capture_output=True, text=True)
    pinned = {requirement.partition("==")[0] for requirement in run.stdout.split()}
    extras = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["optional-dependencies"]
    needed = [line for name, lines in extras.items() if name not in ("docs", "test") for line in lines]
    assert {re.split(r"[\[>]", line)[0] for line in needed} <= pinned


def test_files_of_citation_agree():
    zenodo = json.loads((ROOT / ".zenodo.json").read_text())
    citation = yaml.safe_load((ROOT / ".github" / "CITATION.cff").read_text())
    assert citation["title"] == zenodo["title"]
    assert citation["license"] == zenodo["license"]
    assert citation["keywords"] == zenodo["keywords"]
    assert [author["name"] for author in citation["authors"]] == [author["name"] for author in zenodo["creators"]]


@pytest.mark.parametrize("folder", ["tests/benchmarks", "datasets"])
def test_scripts_that_no_test_runs_take_names_that_exist(folder):
    for path in sorted((ROOT / folder).glob("*.py")):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Attribute) and ast.unparse(node.value) == "roughxr":
                getattr(roughxr, node.attr)
            if isinstance(node, ast.ImportFrom) and str(node.module).partition(".")[0] == "roughxr":
                module = importlib.import_module(node.module)
                for name in node.names:
                    if not hasattr(module, name.name):
                        importlib.import_module(f"{node.module}.{name.name}")
