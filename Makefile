# make install | demo | test | lint | dev | bench | audit | docs | fit-demo | clean
# LEVELS: native builds the engine for this machine alone; all, or "v2 v3", for others (x86-64 levels)
PYTHON ?= python3
ifneq ($(filter bench,$(MAKECMDGOALS)),)  # races the levels against one another
LEVELS ?= all
endif
LEVELS ?= native
VENV := .venv
BIN := $(VENV)/bin
comma := ,
empty :=
LEVELS_ID := $(subst $(empty) $(empty),-,$(strip $(LEVELS)))
ENGINE := $(VENV)/.engine-$(LEVELS_ID)
BUILD := build/engine
PIP := $(BIN)/python -m pip install -qq --disable-pip-version-check
CORE := $(shell find core -name '*.?pp')
RUN := $(ENGINE) $(VENV)/.with-track$(comma)report

.PHONY: audit install demo test test-aarch64 sanitize lint dev bench docs fit-demo clean toolchain

install: $(RUN)

demo: $(RUN)
	$(BIN)/jink track examples/flights.parquet --smooth -o demo.parquet --report demo.html

# by as many processes as there are cores, four at most: each takes up to 4 GB
test: $(ENGINE) $(VENV)/.with-test
	$(BIN)/python -m pytest -n auto --maxprocesses 4 --dist worksteal

# the engine cross-compiled for 64-bit ARM, its oracle and contract tests under qemu-user; see scripts/test_aarch64.sh
test-aarch64: $(VENV)/.with-test
	scripts/test_aarch64.sh

# the whole suite under AddressSanitizer and UBSan, and batches and live targets under TSan; see scripts/sanitize.sh
sanitize: $(VENV)/.with-test
	scripts/sanitize.sh

dev: $(ENGINE) $(VENV)/.with-dev

lint: dev
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/codespell
	$(BIN)/pyright

# licences of all that jink[all] brings, and known faults of it
audit: $(VENV)/.with-all
	@$(PIP) packaging
	@$(PIP) pip-audit || true
	$(BIN)/python scripts/licences.py
	$(BIN)/python scripts/known_faults.py

bench: $(ENGINE) $(VENV)/.with-bench
	$(BIN)/python -m benchmarks.run $(BENCH)

# the documentation as a site: build/site/README.html
docs: $(VENV)/.with-docs
	$(BIN)/python scripts/make_docs.py

fit-demo: $(ENGINE) $(VENV)/.with-track$(comma)report$(comma)fit
	$(BIN)/jink fit examples/flights.parquet --starts 1 --minutes 0.4 -o fitted.json --report fitted.html

clean:
	rm -rf build $(VENV) src/jink/_native_*.so demo.html demo.parquet fitted.json fitted.html

toolchain:
	@$(PYTHON) scripts/check_toolchain.py

$(VENV)/.tools: | toolchain
	@echo "making $(VENV) with what builds the engine"
	@test -x $(BIN)/python || $(PYTHON) -m venv $(VENV)
	@$(PIP) "scikit-build-core>=0.10" "nanobind>=2.4" cmake ninja
	@touch $@

# The engine goes beside its Python sources; the modules of a build before are not left to be taken for this one's.
$(ENGINE): CMakeLists.txt src/jink/_processor.py $(CORE) | $(VENV)/.tools
	@echo "compiling the engine ($(LEVELS)): about two minutes the first time"
	@$(BIN)/cmake -G Ninja -S . -B $(BUILD) -DCMAKE_MAKE_PROGRAM=$(abspath $(BIN)/ninja) -DPython_EXECUTABLE=$(abspath $(BIN)/python) \
	  -DJINK_LEVELS="$(LEVELS)" -DCMAKE_INSTALL_PREFIX=$(abspath src) > $(VENV)/configure.log 2>&1 || { cat $(VENV)/configure.log; exit 1; }
	@NINJA_STATUS="compiling %f of %t: " $(BIN)/cmake --build $(BUILD)
	@rm -f src/jink/_native_*.so $(VENV)/.engine-*
	@$(BIN)/cmake --install $(BUILD) > /dev/null
	@touch $@

# The package in place, with the extras in the stamp's name; a new module needs no new install.
$(VENV)/.with-%: pyproject.toml | $(VENV)/.tools
	@echo "installing jink[$*]"
	@$(PIP) --no-build-isolation --config-settings=wheel.cmake=false --config-settings=editable.mode=inplace --editable ".[$*]"
	@touch $@
