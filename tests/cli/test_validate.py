"""``hradiosity validate``: cases from the scene format to the verdict, the page and the exit status."""

import copy
import json
from xml.etree import ElementTree

import pytest

from hradiosity.suites.validation import data


@pytest.fixture(autouse=True)
def one_device(monkeypatch, device):
    """Serves all calls, so that its kernels are loaded once."""
    monkeypatch.setattr("hradiosity.device.Device", lambda spec=None: device)


QUICK = ("--case", "5.2-lambertian", "--case", "5.3")


def test_two_cases_pass_and_are_reported(call, tmp_path):
    page = tmp_path / "report.html"
    outcome = call("validate", *QUICK, "--report", page)
    assert outcome.code == 0
    assert "all within their bars" in outcome.out and "FAIL" not in outcome.out
    assert outcome.out.count(" pass\n") == 10 + 14 + 2
    tree = ElementTree.fromstring(page.read_text(encoding="utf-8"))
    svg = "{http://www.w3.org/2000/svg}"
    assert len(tree.findall(f".//{svg}svg")) == 2
    assert {heading.get("id") for heading in tree.iter("h3")} == {"5.2-lambertian", "5.3"}
    assert [link.get("href") for link in tree.iter("a")] == ["#5.2-lambertian", "#5.3"]
    assert len(tree.findall(".//details//tr")) == (10 + 1) + (14 + 1)
    text = " ".join(tree.itertext())
    for part in ("from first principles", "pyopencl", "PoCL"):
        assert part in text
    for outside in ("http://", "https://", "src="):
        assert outside not in page.read_text(encoding="utf-8").replace(svg[1:-1], "")


def test_a_wrong_reference_fails(call, monkeypatch, tmp_path):
    known = copy.deepcopy(data.cie171())
    known["5.3"]["points"]["F"]["value"] *= 1.002
    monkeypatch.setattr(data, "cie171", lambda: known)
    page = tmp_path / "report.html"
    outcome = call("validate", *QUICK, "--report", page)
    assert outcome.code == 1
    assert "outside their bars: 5.3" in outcome.out
    assert outcome.out.count("FAIL") == 2  # the point, and its case in the summary
    tables = ElementTree.fromstring(page.read_text(encoding="utf-8")).iter("details")
    (details,) = [table for table in tables if table.get("open")]
    assert [row[0].text for row in details.iter("tr") if row.get("class") == "bad"] == ["F"]


def test_json(call):
    outcome = call("validate", "--case", "5.3", "--json")
    found = json.loads(outcome.out)
    assert found["passed"] and [case["name"] for case in found["cases"]] == ["5.3"]
    (case,) = found["cases"]
    assert len(case["points"]) == 14 and abs(case["points"][0]["deviation"]) < 1e-3
    assert "5.3: pass" in outcome.err


@pytest.mark.parametrize(
    ("word", "suggestion"), [("5.33", "5.3"), ("cube-iso-rho0.5", "cube-iso-rho0.50"), ("qqq", "--list")]
)
def test_unknown_case(call, word, suggestion):
    outcome = call("validate", "--case", "5.3", "--case", word)
    assert outcome.code == 2 and outcome.out == ""
    assert repr(word) in outcome.err and suggestion in outcome.err


def test_list_names_what_is_not_run(call):
    lines = call("validate", "--case", "5.9", "--list").out.splitlines()
    assert lines[0].startswith("5.9-1x1-t5: Roof opening")
    assert len(lines) == 8 and all("not run" in line and "uniform" in line for line in lines[1:])


def test_a_report_that_cannot_be_written(call, tmp_path):
    outcome = call("validate", "--case", "5.2", "--report", tmp_path / "no" / "folder.html")
    assert outcome.code == 2 and "folder.html" in outcome.err
