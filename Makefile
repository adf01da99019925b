# make demo | studio | test | bench | soak | test-clients | screenshots | sample: each makes .venv and installs what is missing.
PYTHON ?= python3
BIN := .venv/bin
RUNTIME := .venv/.runtime
DEVELOPMENT := .venv/.development
XVFB := xvfb-run -a -s "-screen 0 2560x1440x24"

.PHONY: demo studio test lint bench soak test-clients screenshots sample clean

demo: $(RUNTIME)
	$(BIN)/quasiface demo --out out/demo

studio: $(RUNTIME)
	$(BIN)/quasiface studio

test: $(DEVELOPMENT)
	$(MAKE) --no-print-directory lint
	$(BIN)/python -m pytest

lint: $(DEVELOPMENT)
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports

bench: $(DEVELOPMENT)
	$(BIN)/python -m tests.benchmarks

soak: $(DEVELOPMENT)
	$(XVFB) $(BIN)/python -m tests.journeys.kill --kills 100 --at-once 3

# Blender is no dependency: the module bpy (GPL, 370 MB) gets an environment of its own.
test-clients: $(RUNTIME)
	test -x .clients/bin/python || $(PYTHON) -m venv .clients
	.clients/bin/python -m pip install --quiet --disable-pip-version-check 'bpy>=4.2'
	mkdir -p out/clients
	$(BIN)/python -m tests.clients.rig out/clients
	.clients/bin/python -m tests.clients.blender out/clients/rig.glb out/clients/rig.npz

screenshots: $(DEVELOPMENT)
	XDG_STATE_HOME=$$(mktemp -d) $(XVFB) $(BIN)/python docs/make_screenshots.py

sample: $(DEVELOPMENT)
	$(BIN)/python -m resources.template.build
	$(BIN)/python -m resources.sample.build

clean:
	rm -rf .venv .clients node_modules out build *.egg-info

.venv/bin/python:
	sh scripts/system_libraries.sh
	$(PYTHON) -m venv .venv

$(RUNTIME): pyproject.toml | .venv/bin/python
	sh scripts/system_libraries.sh
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable .
	touch $@

$(DEVELOPMENT): pyproject.toml package.json $(RUNTIME)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable '.[dev]'
	PATH="$(CURDIR)/$(BIN):$$PATH" $(BIN)/npm install --no-package-lock --no-audit --no-fund --loglevel=error
	touch $@
