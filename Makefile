# quadwalk without a ROS installation: everything comes from PyPI into .venv, in the versions of
# requirements.lock. In a ROS 2 workspace use colcon instead.

VENV := .venv
BIN := $(VENV)/bin
PIP := $(BIN)/python -m pip --disable-pip-version-check -qq
# Another interpreter: make venv PYTHON=python3.10
PYTHON ?=
# More for the command behind a target: make test ARGS='-k gait', make demo ARGS='--seed 3'
ARGS ?=

# A sourced ROS installation, or another environment, must not reach into .venv.
unexport PYTHONPATH PYTHONHOME LD_LIBRARY_PATH AMENT_PREFIX_PATH _ROS_WHEELS_BOOTSTRAP_COMPLETE
# Without bytecode every process that is started compiles all that it imports: a third more for a node.
unexport PYTHONDONTWRITEBYTECODE

.DEFAULT_GOAL := help
.DELETE_ON_ERROR:
.NOTPARALLEL:
.PHONY: help venv demo view test sweeps smoke smokes bench lint lock site tf nav2 simulation control interfaces clean

help:
	@echo 'make demo    set everything up and let TITAN-VIII walk over the sample map to a goal'
	@echo 'make view    set everything up and show a robot on a page in the browser, where a click lets it walk'
	@echo 'make test    set everything up and run the tests'
	@echo 'make sweeps  run the tests of laws that hold in many cases in all of them; make test runs a few'
	@echo 'make smokes  on each other Python that is there: set up, walk once over topics, test the core'
	@echo 'make bench   measure how well it walks, and print a table'
	@echo 'make lint    ruff and mypy'
	@echo 'make site    build the documents as a site in build/site'
	@echo 'make venv    set everything up in .venv, and nothing else'
	@echo 'make tf      build tf2_msgs into .venv, so that the nodes publish tf (optional; CMake, a C++ compiler)'
	@echo "make nav2    build nav2_msgs and map_msgs into .venv, for Nav2's actions and updates of maps (optional; the same)"
	@echo 'make simulation  build simulation_interfaces into .venv, for services that spawn robots (optional; the same)'
	@echo 'make control  build control_msgs into .venv, for controllers that take an action (optional; the same)'
	@echo 'make interfaces  all four of them: then make test leaves none of their tests out'
	@echo 'make lock    write requirements.lock anew (python3.10 to python3.13)'
	@echo 'make clean   remove .venv and everything else that was built'
	@echo "Arguments for the command behind a target: make test ARGS='-k gait'"

# PyBullet has wheels up to Python 3.11: these come first.
$(BIN)/python:
	@set -e; found=; \
	for python in $(or $(PYTHON),python3.11 python3.10 python3 python3.12 python3.13); do \
	    if $$python -c 'import sys, venv, ensurepip; sys.exit(not (3, 10) <= sys.version_info < (3, 14))' \
	            >/dev/null 2>&1; then found=$$python; break; fi; \
	done; \
	if [ -z "$$found" ]; then \
	    echo 'quadwalk needs Python 3.10 to 3.13 with venv and pip; on Debian and Ubuntu: sudo apt install python3 python3-venv (where that is 3.10 or newer)' >&2; \
	    exit 1; \
	fi; \
	echo "Setting up .venv with $$($$found --version) (once; about a minute) ..."; \
	rm -rf $(VENV); $$found -m venv $(VENV)

$(VENV)/requirements.stamp: requirements.lock | $(BIN)/python
	@$(PIP) install --requirement requirements.lock || \
	    { echo 'The packages of requirements.lock could not be installed: see the message above; pip must reach a package index' >&2; exit 1; }
	@$(BIN)/python -c 'import pybullet' >/dev/null 2>&1 || \
	    echo 'Note: PyBullet has no wheel for this Python. Physics are simulated by MuJoCo'
	@touch $@

# Editable: a change in the sources takes effect at once, a change in the packaging installs again.
$(VENV)/quadwalk.stamp: setup.py setup.cfg pyproject.toml package.xml $(VENV)/requirements.stamp
	@$(PIP) install --no-deps --no-build-isolation --editable .
	@touch $@

venv: $(VENV)/quadwalk.stamp

demo: venv
	@$(BIN)/quadwalk demo $(ARGS)

view: venv
	@$(BIN)/quadwalk view $(ARGS)

# Three at a time keep two processors busy: while one waits for nodes, the others compute. A worker
# that has nothing left to do takes tests over from another. One at a time: make test ARGS='-n 0'
test: venv
	@$(BIN)/python -m pytest -n 3 --dist worksteal --durations=15 $(ARGS)

# Every case of what make test runs in a few cases.
sweeps: venv
	@$(BIN)/python -m pytest -n 3 --dist worksteal --sweeps -m sweep $(ARGS)

# Some of the core: what depends on the version of Python is imports, compiled searches and wheels.
SMOKE := test/common/trajectory test/common/maps test/planner/grid test/planner/search test/gait/following test/sim/engines/test_registry.py

smoke: venv
	@$(BIN)/python --version
	@$(BIN)/quadwalk demo --no-recording --output $(VENV)/demo --goal 2.0,1.6,0.5
	@$(BIN)/python -m pytest -q -n 2 --dist worksteal $(SMOKE)

# pyenv's are found where they are installed, whichever of them is chosen.
PYTHONS ?= python3.10 python3.11 python3.12 python3.13 $(wildcard $(HOME)/.pyenv/versions/3.*/bin/python3)
VERSION := -c 'import sys, venv, ensurepip; print("3.%d" % sys.version_info[1])'
smokes: venv
	@set -e; done=$$($(BIN)/python $(VERSION)); \
	for python in $(PYTHONS); do \
	    version=$$($$python $(VERSION) 2>/dev/null) || continue; \
	    case " 3.10 3.11 3.12 3.13 " in *" $$version "*) ;; *) continue ;; esac; \
	    case " $$done " in *" $$version "*) continue ;; esac; \
	    $(MAKE) --no-print-directory VENV=.venv-$$version PYTHON=$$python smoke; \
	    done="$$done $$version"; \
	done

bench: venv
	@$(BIN)/quadwalk bench $(or $(ARGS),walk)

lint: venv
	@$(BIN)/ruff check .
	@$(BIN)/mypy

# Asks for mkdocs-material where it is not there yet: the lock file has what tests and walks need.
site: venv
	@$(BIN)/python -c 'import material' 2>/dev/null || $(PIP) install --no-build-isolation --editable '.[docs]'
	@$(BIN)/python tools/build_site.py

lock:
	@python3 tools/lock.py --output requirements.lock $(PYTHONS)

tf: venv
	@$(BIN)/python tools/build_messages.py tf2_msgs

nav2: venv
	@$(BIN)/python tools/build_messages.py nav2_msgs map_msgs

simulation: venv
	@$(BIN)/python tools/build_messages.py simulation_interfaces

control: venv
	@$(BIN)/python tools/build_messages.py control_msgs

interfaces: tf nav2 simulation control

clean:
	rm -rf $(VENV) .venv-3.* build install log dist *.egg-info .pytest_cache .mypy_cache .ruff_cache
	find . -name __pycache__ -type d -prune -exec rm -rf {} +
