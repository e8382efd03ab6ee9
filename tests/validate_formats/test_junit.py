"""Reports as JUnit XML."""

from __future__ import annotations

from xml.etree import ElementTree

import pytest

from taskbuilder.validate.formats.junit import junit_xml


@pytest.fixture
def suites(passed, failed):
    return ElementTree.fromstring(junit_xml([passed, failed]).encode())


def cases(suite):
    return {case.get("name"): case for case in suite.iter("testcase")}


def test_a_task_is_a_suite_and_a_check_a_case(suites):
    assert [suite.get("name") for suite in suites] == ["handover", "lift"]
    named = [(case.get("classname"), case.get("name")) for case in suites[0]]
    assert named == [
        ("handover.static", "TB100 keys are right"),
        ("handover.build", "TB306 comes to rest"),
    ]


def test_counts_and_times_are_those_of_the_cases(suites):
    for suite in (suites, *suites):
        found = list(suite.iter("testcase"))
        assert int(suite.get("tests")) == len(found)
        assert int(suite.get("failures")) == sum(c.find("failure") is not None for c in found)
        seconds = sum(float(case.get("time")) for case in found)
        assert float(suite.get("time")) == pytest.approx(seconds, abs=0.01)
    assert [suite.get("skipped") for suite in suites] == ["0", "1"]
    assert [float(suite.get("time")) for suite in suites] == pytest.approx([1.7, 2.0])


def test_nothing_stands_in_it_that_jenkins_would_refuse(suites):
    known = {
        "testsuites": {"name", "time", "tests", "failures", "errors"},
        "testsuite": {"name", "time", "tests", "failures", "errors", "skipped"},
        "testcase": {"name", "time", "classname"},
        "failure": {"type", "message"},
        "skipped": {"type", "message"},
        "system-out": set(),
    }
    for element in suites.iter():
        assert set(element.keys()) <= known[element.tag]


def test_a_failure_lists_its_findings_with_their_places(suites, source):
    case = cases(suites[1])["TB100 keys are right"]
    failure = case.find("failure")
    assert (failure.get("type"), failure.get("message")) == (
        "TB100",
        "is the text; a number is needed",
    )
    assert failure.text.startswith(f"{source}:4:18: error[TB103] mass: is the text")


def test_a_check_that_fails_without_a_finding_shows_its_figure(suites):
    (case,) = [case for name, case in cases(suites[1]).items() if "TB306" in name]
    assert case.find("failure").get("message") == "7.25 mm, limit 5 mm"


def test_a_warning_does_not_fail_a_case(suites):
    case = cases(suites[1])["TB300 robots are sound"]
    assert case.find("failure") is None
    assert "warning[TB308] lighter than foam" in case.find("system-out").text


def test_an_error_of_no_check_fails_a_case_of_its_own(suites):
    (case,) = [case for name, case in cases(suites[1]).items() if "TB999" in name]
    assert case.find("failure").get("type") == "TB999"


def test_a_family_that_was_not_run_is_skipped_and_says_why(suites):
    skipped = cases(suites[1])["reset"].find("skipped")
    assert skipped.get("message") == "not run, as static and build failed"


def test_what_xml_cannot_hold_is_marked(suites):
    (case,) = [case for name, case in cases(suites[1]).items() if "TB999" in name]
    assert case.find("failure").get("message") == "unheard of <script>&\"'�[31m�"
