# make install | test | demo | bench | lint | clean
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin

.PHONY: fit-demo install test test-aarch64 demo bench lint clean toolchain

install: $(VENV)/.installed

toolchain:
	@$(PYTHON) scripts/check_toolchain.py

# rebuilt when the build files or the C++ change; the Python package itself is installed in place
$(VENV)/.installed: pyproject.toml CMakeLists.txt $(wildcard core/*.cpp core/*.hpp) | toolchain
	@test -x $(BIN)/python || $(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check "scikit-build-core>=0.10" "nanobind>=2.4" cmake ninja
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --no-build-isolation --editable ".[dev]"
	@touch $@

test: install
	$(BIN)/python -m pytest

# the engine cross-compiled for 64-bit ARM, its oracle and contract tests under qemu-user; see scripts/test_aarch64.sh
test-aarch64: install
	scripts/test_aarch64.sh

demo: install
	$(BIN)/jink track examples/flights.parquet --smooth -o demo.parquet --report demo.html

bench: install
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable ".[bench]" --no-build-isolation
	$(BIN)/python -m benchmarks.run

lint: install
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/pyright

clean:
	rm -rf build $(VENV) demo.html demo.parquet fitted.json fitted.html

fit-demo: install
	$(BIN)/jink fit examples/flights.parquet --starts 1 --minutes 0.4 -o fitted.json --report fitted.html
