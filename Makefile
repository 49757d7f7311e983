# make demo    install what it needs into .venv, slide the example well for 300 simulated seconds, leave a log and a
#              plot page in out/
# make install install everything into .venv: analysis, live page, tests
# make test    install everything, then lint and the whole test suite
# make lint    ruff, mypy and the import contract alone
# make bench   speed, beside references and other programs, written to docs/reference/benchmarks.md
# make docs    the pages of docs/ as a site in build/site
#
# VENV=DIR uses another environment, PYTHON=PROGRAM makes it with another interpreter.

PYTHON ?= python3
VENV ?= .venv
RECORD ?= out/demo
STAMP = $(VENV)/.slider_drilling_installed
DEMO_STAMP = $(VENV)/.slider_drilling_demo_installed
RUN = $(VENV)/bin/

# A sourced ROS 2 is used where there is one: rclpy is there, and not within the environment itself. Elsewhere it comes
# as wheels from PyPI.
SOURCED = import importlib.util, sys; rclpy = importlib.util.find_spec("rclpy"); \
	sys.exit(rclpy is None or rclpy.origin.startswith(sys.prefix))
EXTRAS = pages,analysis,cluster,frames,tables,identify,live,test,lint

HINT = "make: not installed: ROS wheels are for x86-64 Linux and Python 3.10 to 3.13; elsewhere source a ROS 2 Jazzy first"

# What `ros2 run` and `ros2 launch` look for: an editable install has these beside the environment, not in it.
PROGRAMS = $(shell sed -n '/^console_scripts/,/^$$/s/^    \([a-z_-]*\) =.*/\1/p' setup.cfg)

# Left behind by the ROS wheels of another environment, these would load that environment's libraries.
ifdef _ROS_WHEELS_BOOTSTRAP_COMPLETE
unexport LD_LIBRARY_PATH
unexport AMENT_PREFIX_PATH
endif
unexport _ROS_WHEELS_BOOTSTRAP_COMPLETE

# Tests start hundreds of Python processes: each would compile the package's sources again.
unexport PYTHONDONTWRITEBYTECODE

.PHONY: install demo test lint docs bench clean
.DEFAULT_GOAL := demo

# $(call INSTALL,EXTRAS,WHAT): the package with these extras, and ROS 2 where none is sourced; says what it does.
define INSTALL
	@$(RUN)python -m pip --version >/dev/null 2>&1 \
	|| { echo "making a Python environment in $(VENV)"; $(PYTHON) -m venv $(VENV); }
	@if $(RUN)python -c '$(SOURCED)'; then extras=$(1); ros="the ROS 2 of this shell is used"; \
	else extras=$(1),ros; ros="ROS 2 Jazzy comes as wheels"; fi; \
	echo "installing $(2) into $(VENV); $$ros"; begun=$$(date +%s); \
	$(RUN)python -m pip install --disable-pip-version-check --quiet --constraint constraints.txt --editable ".[$$extras]" \
	|| { echo $(HINT) >&2; exit 1; }; \
	echo "installed in $$(($$(date +%s) - begun)) s: $(VENV) takes $$(du -sh $(VENV) | cut -f1)"
endef

install: $(STAMP)

$(DEMO_STAMP): setup.cfg setup.py constraints.txt
	$(call INSTALL,pages,what the demo needs (about 850 MB on disk, a minute))
	@touch $@

$(STAMP): setup.cfg setup.py constraints.txt
	$(call INSTALL,$(EXTRAS),everything (about 1.7 GB on disk, two minutes))
	@touch $(DEMO_STAMP)
	rm -rf $(VENV)/lib/slider_drilling $(VENV)/share/slider_drilling
	mkdir -p $(VENV)/lib/slider_drilling $(VENV)/share/slider_drilling $(VENV)/share/ament_index/resource_index/packages
	for part in package.xml config; do ln -s "$(CURDIR)/$$part" $(VENV)/share/slider_drilling/; done
	mkdir $(VENV)/share/slider_drilling/launch  # a folder: ros2 launch does not look through links to folders
	ln -s "$(CURDIR)"/launch/* $(VENV)/share/slider_drilling/launch/
	ln -sf "$(CURDIR)/resource/slider_drilling" $(VENV)/share/ament_index/resource_index/packages/
	for program in $(PROGRAMS); do ln -s ../../bin/$$program $(VENV)/lib/slider_drilling/; done
	touch $@

demo: $(DEMO_STAMP)
	$(RUN)slider-drilling run --duration 300 --speed max --record $(RECORD)

lint: $(STAMP)
	$(RUN)ruff check .
	$(RUN)mypy
	$(RUN)lint-imports

# Twice as many workers as cores: a third of the tests' time is waiting for other processes.
test: lint
	$(RUN)python -m pytest -n 4 --dist worksteal

docs: $(STAMP)
	$(RUN)python -m pip install --quiet --editable '.[docs]'
	NO_MKDOCS_2_WARNING=1 $(RUN)mkdocs build --strict

bench: $(STAMP)
	$(RUN)python -m pip install --disable-pip-version-check --quiet --editable '.[bench]'
	$(RUN)python -W ignore -m slider_drilling.benchmarks

clean:
	rm -rf $(VENV) out build dist *.egg-info
