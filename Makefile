# make serve   the service and the page      SCENE=path/to/scene PORT=8000
# make test    everything CI runs
# make sweep   tests that take long, beside those
# make bench   timings of this machine
# make rivals  the same against Mitsuba 3, alone and denoised   SCENE=...
# make chart   speed against accuracy        SCENE=..., into out/chart
# make screenshots   the pictures of the page in the README, by the page itself
# make clean   remove the environment and everything built

PYTHON ?= python3
SCENE ?= cornell-box
PORT ?= 8000

BIN := .venv/bin
GL_PACKAGES := libegl1 libgl1 libgl1-mesa-dri
# A browser for the page, and a library that Mitsuba's wheels take for granted.
TEST_PACKAGES := $(GL_PACKAGES) chromium libatomic1
# What is of the system as a whole, and as much of its parts that the other half takes as long.
# In this order both seldom compile the same kernels at a time, nor does a service that a test starts:
# the path tracer's here, those of the methods there.
SYSTEM_TESTS := tests/analytic tests/measure tests/stability tests/cli tests/reference tests/web \
  tests/numerics tests/scene tests/store
UNIT_TESTS := tests/methods $(filter-out tests/methods tests/__pycache__ $(SYSTEM_TESTS), \
  $(patsubst %/,%,$(wildcard tests/*/)) $(wildcard tests/test_*.py))
PEER_PACKAGES := libllvm19 libatomic1

.PHONY: serve test lint types pytest pytest-units pytest-system sweep test-packages bench rivals chart screenshots clean

serve: .venv/.run
	@.ci/system-packages $(GL_PACKAGES) || echo "going on without OpenGL, on the CPU" >&2
	$(BIN)/relight serve "$(SCENE)" --port $(PORT)

# Side by side: each keeps about one core busy.
test:
	@$(MAKE) --no-print-directory -j4 --output-sync=line lint types pytest

lint: .venv/.test
	$(BIN)/ruff check
	$(BIN)/ruff format --check

types: .venv/.test
	$(BIN)/mypy

pytest: pytest-units pytest-system
# Two of them share the cores.
pytest-units pytest-system: export OPENBLAS_NUM_THREADS := 1

pytest-units: .venv/.test test-packages
	$(BIN)/pytest -m "not sweep" $(UNIT_TESTS)

pytest-system: .venv/.test test-packages
	$(BIN)/pytest -m "not sweep" $(SYSTEM_TESTS)

sweep: .venv/.test test-packages
	$(BIN)/pytest -m sweep --timeout 14400

test-packages:
	@.ci/system-packages $(TEST_PACKAGES)

bench: .venv/.chart
	$(BIN)/relight bench

# Against Mitsuba 3, which is twice as fast with an LLVM that it gets on with.
rivals: .venv/.peers
	@.ci/system-packages $(PEER_PACKAGES) || echo "going on without LLVM, on scalar_rgb" >&2
	$(BIN)/relight bench "$(SCENE)" --rivals

chart: .venv/.chart
	$(BIN)/relight chart "$(SCENE)" --method direct_to_indirect --out out/chart

screenshots: .venv/.test test-packages
	$(BIN)/python tests/web/screenshots.py docs

clean:
	rm -rf .venv dist build out .pytest_cache .mypy_cache .ruff_cache
	find engine server tests -name __pycache__ -prune -exec rm -rf {} +

# The environment, and stamps in it for what it holds.
.venv/bin/python:
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || \
	  { echo "relight needs Python 3.11 or newer; this is `$(PYTHON) --version` (make PYTHON=...)" >&2; exit 1; }
	@$(PYTHON) -c 'import ensurepip, venv' 2>/dev/null || .ci/system-packages \
	  `$(PYTHON) -c 'import sys; print("python%d.%d-venv" % sys.version_info[:2])'`
	$(PYTHON) -m venv .venv || { rm -rf .venv; exit 1; }

.venv/.run: .venv/bin/python pyproject.toml
	$(BIN)/pip install -q -e .
	@touch $@

.venv/.chart: .venv/.run
	$(BIN)/pip install -q -e '.[chart]'
	@touch $@

.venv/.peers: .venv/.chart
	$(BIN)/pip install -q -e '.[peers]'
	@touch $@

# Which holds the other three.
.venv/.test: .venv/bin/python pyproject.toml
	$(BIN)/pip install -q --no-compile -e '.[test]'
	@touch .venv/.run .venv/.chart .venv/.peers $@
