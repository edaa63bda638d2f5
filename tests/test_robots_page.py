"""The page for robots' authors: its examples are the contract's, and every rule of the check has its section."""

import json
import re
from pathlib import Path

import pytest

from app.cli.trials.conformance.rules import PAGE, Rule
from robots.link.mqtt.contract_examples import example, examples

TEXT = (Path(__file__).parent.parent / PAGE).read_text()
BLOCKS = [json.loads(block) for block in re.findall(r"```json\n(.*?)```", TEXT, re.DOTALL)]
OPTIONAL = {
    "delegation_report",
    "fault_report",
    "mind_order",
    "mind_order_report",
    "mind_query",
    "mind_report",
    "mind_transfer",
    "mind_transfer_report",
    "retune",
    "rule_set",
    "rules_report",
    "sample_report",
    "set_point",
    "set_point_refusal",
    "speech_act",
    "speech_report",
    "trace_query",
    "trace_report",
    "tuning_report",
    "upkeep_report",
}


def test_the_examples_are_those_of_the_contract() -> None:
    published = {name: example(name) for name in examples()}
    assert all(block in published.values() for block in BLOCKS)
    shown = {name for name, one in published.items() if one in BLOCKS}
    assert published.keys() - shown == OPTIONAL


@pytest.mark.parametrize("rule", list(Rule))
def test_every_rule_has_its_section(rule: Rule) -> None:
    assert re.search(rf"^#+ {rule.value}$", TEXT, re.MULTILINE)
