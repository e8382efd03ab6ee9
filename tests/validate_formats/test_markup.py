"""Markup that is escaped by construction."""

from __future__ import annotations

from taskbuilder.validate.formats.markup import Html, element, join


def test_text_never_becomes_markup():
    made = element("p", "<b>&", title="\"'><i>").text
    assert made == '<p title="&quot;&#x27;&gt;&lt;i&gt;">&lt;b&gt;&amp;</p>'


def test_markup_stays_markup():
    assert element("p", element("b", "x"), [Html("<hr>"), "y"], None).text == "<p><b>x</b><hr>y</p>"


def test_attributes_that_are_true_have_no_value_and_those_that_are_none_are_left_out():
    made = element("img", class_="big", hidden=True, alt=None, aria_label="a").text
    assert made == '<img class="big" hidden aria-label="a">'


def test_what_no_document_can_hold_is_marked():
    assert join("a\x00b\x1bc\udc80d\ufffe\n").text == "a�b�c�d�\n"
