# make demo    install into .venv, slide the example well for 300 simulated seconds, leave a log and a plot page in out/
# make test    install into .venv, then lint and the whole test suite
# make lint    ruff, mypy and the import contract alone
# make bench   speed, beside references and other programs, written to docs/benchmarks.md
# make docs    the pages of docs/ as a site in build/site
#
# VENV=DIR uses another environment, PYTHON=PROGRAM makes it with another interpreter.

PYTHON ?= python3
VENV ?= .venv
RECORD ?= out/demo
STAMP = $(VENV)/.slider_drilling_installed
RUN = $(VENV)/bin/

# A sourced ROS 2 is used where there is one: rclpy is there, and not within the environment itself. Elsewhere it comes
# as wheels from PyPI.
SOURCED = import importlib.util, sys; rclpy = importlib.util.find_spec("rclpy"); \
	sys.exit(rclpy is None or rclpy.origin.startswith(sys.prefix))
EXTRAS = analysis,frames,identify,live,test,lint

HINT = "make: not installed: ROS wheels are for x86-64 Linux and Python 3.10 to 3.13; elsewhere source a ROS 2 Jazzy first"

# What `ros2 run` and `ros2 launch` look for: an editable install has these beside the environment, not in it.
PROGRAMS = slider-drilling friction_simulator rocking_controller recorder log_player dashboard

# Left behind by the ROS wheels of another environment, these would load that environment's libraries.
ifdef _ROS_WHEELS_BOOTSTRAP_COMPLETE
unexport LD_LIBRARY_PATH
unexport AMENT_PREFIX_PATH
endif
unexport _ROS_WHEELS_BOOTSTRAP_COMPLETE

.PHONY: install demo test lint docs bench clean
.DEFAULT_GOAL := demo

install: $(STAMP)

$(STAMP): setup.cfg setup.py
	$(RUN)python -m pip --version >/dev/null 2>&1 || $(PYTHON) -m venv $(VENV)
	if $(RUN)python -c '$(SOURCED)'; then extras=$(EXTRAS); else extras=$(EXTRAS),ros; fi; \
	$(RUN)python -m pip install --disable-pip-version-check --quiet --editable ".[$$extras]" \
	|| { echo $(HINT) >&2; exit 1; }
	rm -rf $(VENV)/lib/slider_drilling $(VENV)/share/slider_drilling
	mkdir -p $(VENV)/lib/slider_drilling $(VENV)/share/slider_drilling $(VENV)/share/ament_index/resource_index/packages
	for part in package.xml config; do ln -s "$(CURDIR)/$$part" $(VENV)/share/slider_drilling/; done
	mkdir $(VENV)/share/slider_drilling/launch  # a folder: ros2 launch does not look through links to folders
	ln -s "$(CURDIR)"/launch/* $(VENV)/share/slider_drilling/launch/
	ln -sf "$(CURDIR)/resource/slider_drilling" $(VENV)/share/ament_index/resource_index/packages/
	for program in $(PROGRAMS); do ln -s ../../bin/$$program $(VENV)/lib/slider_drilling/; done
	touch $@

demo: $(STAMP)
	$(RUN)slider-drilling run --duration 300 --speed max --record $(RECORD)

lint: $(STAMP)
	$(RUN)ruff check .
	$(RUN)mypy
	$(RUN)lint-imports

test: lint
	$(RUN)python -m pytest -n 2

docs: $(STAMP)
	$(RUN)python -m pip install --quiet --editable '.[docs]'
	$(RUN)mkdocs build --strict

bench: $(STAMP)
	$(RUN)python -m pip install --disable-pip-version-check --quiet --editable '.[bench]'
	$(RUN)python -W ignore -m benchmarks

clean:
	rm -rf $(VENV) out build dist *.egg-info
