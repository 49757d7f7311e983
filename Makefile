# make demo    install into .venv, slide the example well for 300 simulated seconds, leave a log and a plot page in out/
# make test    install into .venv, then lint and the whole test suite
# make lint    ruff, mypy and the import contract alone
#
# VENV=DIR uses another environment, PYTHON=PROGRAM makes it with another interpreter.

PYTHON ?= python3
VENV ?= .venv
RECORD ?= out/demo
STAMP = $(VENV)/.slider_drilling_installed
RUN = $(VENV)/bin/

# A sourced ROS 2 is used where there is one; elsewhere rclpy comes as wheels from PyPI.
EXTRAS = $(shell $(PYTHON) -c 'import rclpy' 2>/dev/null || echo ros,)analysis,identify,test,lint

# What `ros2 run` and `ros2 launch` look for: an editable install has these beside the environment, not in it.
PROGRAMS = slider-drilling friction_simulator rocking_controller recorder log_player

# Left behind by the ROS wheels of another environment, these would load that environment's libraries.
ifdef _ROS_WHEELS_BOOTSTRAP_COMPLETE
unexport LD_LIBRARY_PATH
unexport AMENT_PREFIX_PATH
endif
unexport _ROS_WHEELS_BOOTSTRAP_COMPLETE

.PHONY: install demo test lint clean
.DEFAULT_GOAL := demo

install: $(STAMP)

$(STAMP): setup.cfg setup.py
	test -x $(RUN)python || $(PYTHON) -m venv $(VENV)
	$(RUN)python -m pip install --disable-pip-version-check --quiet --editable '.[$(EXTRAS)]'
	mkdir -p $(VENV)/lib/slider_drilling $(VENV)/share/ament_index/resource_index/packages
	ln -sfn $(CURDIR) $(VENV)/share/slider_drilling
	ln -sf $(CURDIR)/resource/slider_drilling $(VENV)/share/ament_index/resource_index/packages/
	for program in $(PROGRAMS); do ln -sf ../../bin/$$program $(VENV)/lib/slider_drilling/; done
	touch $@

demo: $(STAMP)
	$(RUN)slider-drilling run --duration 300 --speed max --record $(RECORD)

lint: $(STAMP)
	$(RUN)ruff check .
	$(RUN)mypy
	$(RUN)lint-imports

test: lint
	$(RUN)python -m pytest -n 2

clean:
	rm -rf $(VENV) out build dist *.egg-info
