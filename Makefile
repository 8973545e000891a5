PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin

PYTEST := $(BIN)/python -m pytest -n auto --dist worksteal --ignore tests/conformance

# Each process of pytest would compile all tests anew.
unexport PYTHONDONTWRITEBYTECODE

# setuptools packs whatever an earlier build left in build/, deleted modules included,
# and a stale egg-info in the working directory hides the installed metadata.
BUILD_LEFTOVERS := build mbcheck.egg-info

define install
rm -rf $(BUILD_LEFTOVERS)
$(BIN)/python -m pip install --quiet "$(1)"
rm -rf $(BUILD_LEFTOVERS)
endef

# Exudyn needs OpenGL's library, which slim containers lack.
define libraries
@$(BIN)/python -c "import exudyn" 2>/dev/null || \
	{ [ "$$(id -u)" = 0 ] && command -v apt-get >/dev/null && \
	  apt-get update -qq && apt-get install -y -qq libgl1 >/dev/null; } || true
endef

.PHONY: check test test-all test-slow foreign campaigns docs lint clean install install-test

check: install
	$(BIN)/mbcheck check

test: install-test
	$(BIN)/mbcheck check
	$(PYTEST)

test-all: install-test
	$(BIN)/mbcheck check --full
	$(PYTEST) -m "not campaign"

test-slow: install-test
	$(PYTEST) -m slow

# Other engines, older releases and public models: fails where one cannot be had.
foreign: install-test
	$(BIN)/python -m pip install --quiet ".[pinocchio,drake,dart]" mujoco-warp "mujoco-mjx" jax
	$(PYTEST) -m foreign

campaigns: install-test
	$(PYTEST) -m campaign -s

# The pages keep their places in the clone, so that links hold on GitHub and on the site.
PAGES := README.md CONTRIBUTING.md CHANGELOG.md SKILL.md CITATION.cff LICENSE docs examples benchmarks .github
docs: $(BIN)/pip
	$(call install,.[docs])
	$(libraries)
	mkdir -p build/pages
	ln -sfn $(foreach page,$(PAGES),../../$(page)) build/pages/
	$(BIN)/python -m mkdocs build --strict

# mypy reads the clone, not what is installed; it must see it under the package's name.
lint: install-test
	$(BIN)/python -m ruff check .
	$(BIN)/python -m ruff format --check .
	mkdir -p $(VENV)/types
	ln -sfn ../.. $(VENV)/types/mbcheck
	cd $(VENV)/types && ../bin/python -m mypy --config-file mbcheck/pyproject.toml -p mbcheck

install: $(BIN)/pip
	$(call install,.)
	$(libraries)

install-test: $(BIN)/pip
	$(call install,.[test])
	$(libraries)

$(BIN)/pip:
	$(PYTHON) -m venv $(VENV)

clean:
	rm -rf $(VENV) $(BUILD_LEFTOVERS) dist .pytest_cache .mypy_cache .ruff_cache
	find . -name __pycache__ -type d -prune -exec rm -rf {} +
