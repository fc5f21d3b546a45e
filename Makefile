# `make demo` and `make test` set themselves up in .venv; nothing but Python 3.11+, git and make is needed.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
# Control is compiled when it is first imported: once here, and not by several tests at the same time.
COMPILE = $(BIN)/python -c 'import humanoid_bt.session.lockstep'
# A compiler or Python's headers may be missing: said here, by the reasons of tests that are skipped, and tried again.
MESSAGES = $(VENV)-ros/bin/humanoid-bt interfaces vision_msgs tf2_msgs -o $(VENV)-ros/wheels \
	&& $(VENV)-ros/bin/python -m pip install --quiet --disable-pip-version-check --no-index --no-deps --force-reinstall $(VENV)-ros/wheels/*.whl \
	&& touch $(VENV)-ros/.messages \
	|| echo "test-ros: vision_msgs and tf2_msgs could not be built, see above: their tests are SKIPPED" >&2
export OMP_NUM_THREADS ?= 1
export OPENBLAS_NUM_THREADS ?= 1

.PHONY: demo test test-trials test-docs test-cluster test-policy test-ros test-install check docs bench clean

demo: $(VENV)/.installed
	$(BIN)/humanoid-bt run fetch

# They start hundreds of Python processes, which are not to compile the package each time.
test test-trials: export PYTHONDONTWRITEBYTECODE :=
test: $(VENV)/.installed-dev
	$(BIN)/python -m pytest -n auto --dist loadfile -m "not realtime and not trials and not docs and not install and not ray and not policy and not ros"
	$(BIN)/python -m pytest -m "realtime and not trials and not ros" $$(grep -rl mark.realtime tests)

test-trials: $(VENV)/.installed-dev  ## further cases of what a whole robot does, and the bench of realtime mode
	$(BIN)/python -m pytest -n auto --dist worksteal -m "trials and not realtime" $(if $(PART),--part $(PART))
	$(BIN)/python -m pytest -m "trials and realtime" $(if $(PART),--part $(PART)) $$(grep -rl mark.realtime tests)

test-docs: $(VENV)/.installed-dev  ## every example of the docs, as a reader would run it
	$(BIN)/python -m pytest -n auto --dist load -m docs

test-cluster: $(VENV)-cluster/.installed  ## campaigns on a Ray cluster of two nodes, in an environment of its own
	$(VENV)-cluster/bin/python -m pytest -m ray tests/campaign/test_ray.py

test-policy: $(VENV)-policy/.installed  ## learned walkers: tiny ones, and published ones where they are, in an environment of its own
	$(VENV)-policy/bin/python -m pytest tests/robot/policy tests/control/body/policy tests/session/test_body_choice.py tests/cli/test_bench_body.py tests/bench/test_speed.py tests/policies

test-ros: $(VENV)-ros/.installed  ## the gateway beside real nodes of ROS 2 on this machine, in an environment of its own
	@test -e $(VENV)-ros/.messages || $(MESSAGES)
	$(VENV)-ros/bin/python -m pytest -m ros -rs tests/gateway

test-install: $(VENV)/.installed-dev  ## the wheel in an empty environment, with what it declares to need
	$(BIN)/python -m pytest -m install

check: $(VENV)/.installed-dev  ## lint, format, types, layers
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports

docs: $(VENV)/.installed-dev  ## write the generated parts of the pages
	$(BIN)/python docs/generate.py

bench: $(VENV)/.installed
	$(BIN)/humanoid-bt bench

clean:
	rm -rf $(VENV) $(VENV)-cluster $(VENV)-policy $(VENV)-ros build dist runs .pytest_cache .mypy_cache .ruff_cache

$(VENV)/bin/python:
	$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11) and "Python 3.11 or newer is needed: make PYTHON=python3.11 ...")'
	$(PYTHON) -m venv $(VENV)

$(VENV)/.installed: pyproject.toml constraints.txt | $(VENV)/bin/python
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -c constraints.txt -e '.[test]'
	$(COMPILE)
	touch $@

$(VENV)-cluster/.installed: pyproject.toml constraints.txt
	test -x $(VENV)-cluster/bin/python || $(PYTHON) -m venv $(VENV)-cluster
	$(VENV)-cluster/bin/python -m pip install --quiet --disable-pip-version-check -c constraints.txt -e '.[test,cluster]'
	touch $@

$(VENV)-policy/.installed: pyproject.toml constraints.txt
	test -x $(VENV)-policy/bin/python || $(PYTHON) -m venv $(VENV)-policy
	$(VENV)-policy/bin/python -m pip install --quiet --disable-pip-version-check -c constraints.txt -e '.[test,policy]'
	touch $@

$(VENV)-ros/.installed: pyproject.toml constraints.txt
	test -x $(VENV)-ros/bin/python || $(PYTHON) -m venv $(VENV)-ros
	$(VENV)-ros/bin/python -m pip install --quiet --disable-pip-version-check -c constraints.txt -e '.[test,ros]' ros-kilted-test-msgs
	$(MESSAGES)
	touch $@

$(VENV)/.installed-dev: pyproject.toml constraints.txt | $(VENV)/bin/python
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -c constraints.txt -e '.[dev]'
	$(COMPILE)
	touch $@ $(VENV)/.installed
