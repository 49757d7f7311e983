"""Packaging: names and versions agree in every file, and installed files are found."""

import configparser
import re
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import pytest

from slider_drilling import __version__
from slider_drilling.errors import InputError
from slider_drilling.files.installed_files import installed_file
from slider_drilling.messages.topics import TOPICS


def test_package_xml_agrees_with_the_package(repository: Path) -> None:
    root = ElementTree.parse(repository / "package.xml").getroot()
    assert root.get("format") == "3"
    assert root.findtext("name") == "slider_drilling"
    assert root.findtext("version") == __version__
    assert root.findtext("export/build_type") == "ament_python"


def test_package_xml_names_imported_ros_packages(repository: Path) -> None:
    root = ElementTree.parse(repository / "package.xml").getroot()
    at_run = {one.text for one in root.findall("exec_depend")}
    at_test = at_run | {one.text for one in root.findall("test_depend")}
    of_ros = re.compile(
        r"^\s*(?:from|import) (rclpy|ament_index_python|launch|launch_ros|[a-z_]+_(?:msgs|srvs|interfaces))\b", re.M)
    for folder, named in (("slider_drilling", at_run), ("launch", at_run), ("test", at_test)):
        files = list((repository / folder).rglob("*.py"))
        imported = {name for file in files for name in of_ros.findall(file.read_text())}
        assert imported <= named, (folder, imported - named)
    # Messages are also found by their types' names.
    assert {topic.type.partition("/")[0] for topic in TOPICS.values()} <= at_run


def test_package_xml_names_what_pip_installs(repository: Path) -> None:
    parser = configparser.ConfigParser()
    parser.read(repository / "setup.cfg")
    needed = {re.split(r"[<>=~]", line)[0] for line in parser["options"]["install_requires"].split()}
    root = ElementTree.parse(repository / "package.xml").getroot()
    named = {one.text.removeprefix("python3-") for one in root.findall("exec_depend")}
    # mcap and zstandard come with mcap-ros2-support.
    aliases = {"pyyaml": "yaml", "mcap": "mcap-ros2-support", "zstandard": "mcap-ros2-support"}
    assert {aliases.get(name, name) for name in needed} <= named


def test_quality_declaration_has_version_and_existing_files(repository: Path) -> None:
    text = (repository / "QUALITY_DECLARATION.md").read_text()
    assert f"| Version | {__version__}," in text
    for path in re.findall(r"`([\w.]+(?:/[\w./]*)?)`", text):
        if "/" in path or path.endswith((".xml", ".cfg")) or path == "LICENSE":
            assert (repository / path).exists(), path


def test_setup_cfg_has_what_colcon_needs(repository: Path) -> None:
    parser = configparser.ConfigParser()
    parser.read(repository / "setup.cfg")
    assert "pytest" in parser["options.extras_require"]["test"]
    assert parser["install"]["install_scripts"] == "$base/lib/slider_drilling"
    pyproject = (repository / "pyproject.toml").read_text()
    assert not re.search(r"^\[project\]|^requires-python", pyproject, re.MULTILINE)
    assert "python_requires" not in parser["options"]
    assert (repository / "resource" / "slider_drilling").is_file()


@pytest.mark.parametrize("name", ["rig.example.yaml", "rig.short.yaml", "rig.long.yaml"])
def test_installed_files_are_found(name: str) -> None:
    assert "schema: slider_drilling/rig/1" in installed_file(f"config/{name}").read_text()


def test_missing_shared_file_is_an_input_error() -> None:
    with pytest.raises(InputError, match="install the package again"):
        installed_file("config/no_such_file.yaml")


def test_constraints_pin_what_make_installs(repository: Path) -> None:
    makefile = (repository / "Makefile").read_text()
    assert "--constraint constraints.txt" in makefile
    (extras,) = re.findall(r"^EXTRAS = (\S+)", makefile, re.M)
    setup = configparser.ConfigParser()
    setup.read(repository / "setup.cfg")
    wanted = setup["options"]["install_requires"]
    wanted += "".join(setup["options.extras_require"][extra] for extra in [*extras.split(","), "ros"])
    names = {re.split(r"[<>=~\[; ]", line)[0] for line in wanted.split("\n") if line}
    pins = dict(re.findall(r"^([\w.-]+)==([^;]+);", (repository / "constraints.txt").read_text(), re.M))

    def plain(name: str) -> str:
        return re.sub("[-_.]+", "-", name).lower()

    assert {plain(name) for name in names} <= {plain(name) for name in pins}
