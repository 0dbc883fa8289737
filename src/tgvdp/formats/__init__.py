"""Files in: native, TTOBench, railtoolkit, OSRD, railML, SFERA and tables; told apart by content, SI from here on."""

from tgvdp.formats.detect import load_bytes, read_source
from tgvdp.formats.load import (
    input_digest,
    load_energy_map,
    load_journey,
    load_scenario,
    load_section,
    load_track,
    load_train,
    section_of,
    whole_of,
)
from tgvdp.formats.recorded_run import RecordedRun, load_run
from tgvdp.formats.review.describe import Description, describe_file
from tgvdp.formats.scenario import Scenario

__all__ = [
    "Description",
    "RecordedRun",
    "Scenario",
    "describe_file",
    "input_digest",
    "load_bytes",
    "load_energy_map",
    "load_journey",
    "load_run",
    "load_scenario",
    "load_section",
    "load_track",
    "load_train",
    "read_source",
    "section_of",
    "whole_of",
]
