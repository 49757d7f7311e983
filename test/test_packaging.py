"""What is installed: the same names and versions in every file that states them, shared files found."""

import configparser
import re
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import pytest

from slider_drilling import __version__
from slider_drilling.errors import InputError
from slider_drilling.share import share_file


def test_package_xml_agrees_with_the_package(repository: Path) -> None:
    root = ElementTree.parse(repository / "package.xml").getroot()
    assert root.get("format") == "3"
    assert root.findtext("name") == "slider_drilling"
    assert root.findtext("version") == __version__
    assert root.findtext("export/build_type") == "ament_python"


def test_colcon_finds_what_it_needs_in_setup_cfg(repository: Path) -> None:
    parser = configparser.ConfigParser()
    parser.read(repository / "setup.cfg")
    assert "pytest" in parser["options.extras_require"]["test"]
    assert parser["install"]["install_scripts"] == "$base/lib/slider_drilling"
    pyproject = (repository / "pyproject.toml").read_text()
    assert not re.search(r"^\[project\]|^requires-python", pyproject, re.MULTILINE)
    assert "python_requires" not in parser["options"]
    assert (repository / "resource" / "slider_drilling").is_file()


@pytest.mark.parametrize("name", ["rig.example.yaml", "rig.short.yaml", "rig.long.yaml"])
def test_shared_files_are_found(name: str) -> None:
    assert "schema: slider_drilling/rig/1" in share_file(f"config/{name}").read_text()


def test_missing_shared_file_is_the_users_to_mend() -> None:
    with pytest.raises(InputError, match="install the package again"):
        share_file("config/no_such_file.yaml")
