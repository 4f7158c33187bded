# Two commands on a fresh machine: `make demo` renders the default scene, `make test` checks
# everything. Both install what is missing first; PYTHON=/path/to/python3 chooses the interpreter.

PYTHON ?=
# A process of tests for each core, four at most; a file's tests stay together.
# Each draws and computes on one core: threads of several would wait for each other.
PARALLEL := -n auto --maxprocesses 4 --dist loadfile
test thorough quick: export LP_NUM_THREADS = 1
test thorough quick: export OPENBLAS_NUM_THREADS = 1
VENV_PYTHON := .venv/bin/python

.PHONY: demo test thorough quick lint format clean

demo:
	@PYTHON="$(PYTHON)" tools/setup.sh demo
	@mkdir -p out
	@$(VENV_PYTHON) -m rtbow render -o out/default.exr -o out/default.png
	@echo "The picture: $(CURDIR)/out/default.png"
	@echo "Its radiance: $(CURDIR)/out/default.exr"

test: lint
	$(VENV_PYTHON) -m pytest -m "not thorough" $(PARALLEL)

# All tests, those of tests/thorough.txt, too.
thorough: lint
	$(VENV_PYTHON) -m pytest $(PARALLEL)

# The inner loop: all but the tests that take seconds.
quick: lint
	$(VENV_PYTHON) -m pytest -m "not slow and not thorough" $(PARALLEL)

lint:
	@PYTHON="$(PYTHON)" tools/setup.sh test
	$(VENV_PYTHON) -m ruff check .
	$(VENV_PYTHON) -m ruff format --check .
	$(VENV_PYTHON) -m mypy

format:
	@PYTHON="$(PYTHON)" tools/setup.sh test
	$(VENV_PYTHON) -m ruff format .
	$(VENV_PYTHON) -m ruff check --fix .

# Everything that these targets made; pictures of one's own under out/ stay.
clean:
	rm -rf .venv build dist .mypy_cache .ruff_cache .pytest_cache .hypothesis test-failures
	rm -f out/default.exr out/default.png
	find . -name __pycache__ -type d -prune -exec rm -rf {} +
