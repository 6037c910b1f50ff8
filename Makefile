# Every target makes .venv by itself when it is missing or out of date; nothing has to be typed first.

PYTHON ?= $(shell for p in python3.11 python3.12 python3.13 python3; do \
	$$p -c 'import sys; sys.exit(not (3, 11) <= sys.version_info < (3, 14))' 2>/dev/null && { echo $$p; break; }; done)
BIN := .venv/bin
STAMP := .venv/.installed
DEMO := out/demo
JOBS ?= 2

.PHONY: setup demo test lint types bench docs pretrained proposals python
.DEFAULT_GOAL := setup

setup: $(STAMP)

python:
	@test -n "$(PYTHON)" || { echo "blockstab needs Python 3.11, 3.12 or 3.13, and none was found; install it, or name it: make PYTHON=/path/to/python3.11"; exit 1; }

$(STAMP): pyproject.toml constraints.txt | python
	@test -x $(BIN)/python || $(PYTHON) -m venv .venv
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -c constraints.txt torch
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -c constraints.txt -e '.[dev,docs]'
	@touch $@

demo: $(STAMP)
	$(BIN)/blockstab simulate --preset blocks --count 24 --seed 1 --jobs $(JOBS) --out $(DEMO)/train
	$(BIN)/blockstab simulate --preset blocks --count 12 --seed 2 --jobs $(JOBS) --out $(DEMO)/test
	$(BIN)/python train.py potential=svm data=folder data.root=$(DEMO)/train output=$(DEMO)/svm cache=$(DEMO)/examples jobs=$(JOBS)
	$(BIN)/python train.py potential=mlp data=folder data.root=$(DEMO)/train output=$(DEMO)/mlp cache=$(DEMO)/examples jobs=$(JOBS)
	$(BIN)/blockstab parse $(DEMO)/test/*/ --potentials $(DEMO)/mlp.json --jobs $(JOBS) --out $(DEMO)/parsed
	$(BIN)/python evaluate.py experiment=blocks data=folder data.root=$(DEMO)/test potentials=$(DEMO)/mlp.json out=$(DEMO)/evaluation jobs=$(JOBS)
	@echo "Look at the reports: $(DEMO)/parsed/*/report.html"

test: $(STAMP)
	OMP_NUM_THREADS=1 $(BIN)/python -m pytest -n $(JOBS) tests

lint: $(STAMP)
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .

types: $(STAMP)
	$(BIN)/mypy

bench: $(STAMP)
	OMP_NUM_THREADS=1 $(BIN)/python -m pytest benchmarks --benchmark-columns=min,median,ops

docs: $(STAMP)
	$(BIN)/python docs/tables.py --check
	$(BIN)/sphinx-build -W --keep-going -q -b html docs docs/_build
	@echo "docs/_build/index.html"

pretrained: $(STAMP)
	$(BIN)/python train.py potential=svm output=models/pretrained/svm jobs=$(JOBS)
	$(BIN)/python train.py potential=mlp output=models/pretrained/mlp jobs=$(JOBS)
	$(BIN)/python train.py target=boundary data.preset=objects output=models/pretrained/boundary jobs=$(JOBS)
	$(BIN)/python train.py target=stages data.preset=objects data.count=100 output=models/pretrained/silberman jobs=$(JOBS)

# First segmentations against each other: on simulated objects, half of which train, and on a folder of scenes in
# four folds, of which three train. make proposals OSD=path/of/osd
PROPOSALS := out/proposals
SIMULATED := data=simulated data.preset=objects data.count=100 data.seed=4000 split=halves
FOLDED = data=folder data.root=$(OSD) split=folds split.together=4
proposals: $(STAMP)
	@test -n "$(OSD)" || { echo "say where the scenes are: make proposals OSD=path/of/osd"; exit 1; }
	$(BIN)/python train.py target=stages $(SIMULATED) part=train output=$(PROPOSALS)/simulated jobs=$(JOBS)
	$(BIN)/python evaluate.py experiment=proposals experiment.stages=$(PROPOSALS)/simulated.json $(SIMULATED) part=test \
		out=$(PROPOSALS)/simulated jobs=$(JOBS)
	cp $(PROPOSALS)/simulated/results.json docs/results/proposals_objects.json
	for fold in 0 1 2 3; do \
		$(BIN)/python train.py target=stages $(FOLDED) part=train$$fold output=$(PROPOSALS)/stages$$fold jobs=$(JOBS) && \
		$(BIN)/python evaluate.py experiment=proposals experiment.stages=$(PROPOSALS)/stages$$fold.json $(FOLDED) \
			part=test$$fold out=$(PROPOSALS)/fold$$fold jobs=$(JOBS) || exit 1; \
	done
	$(BIN)/python docs/pool.py $(PROPOSALS)/fold?/results.json --out docs/results/proposals_osd.json
	$(BIN)/python -m benchmarks.atoms --root $(OSD) --out docs/results/atoms_osd.json --jobs $(JOBS)
	$(BIN)/blockstab simulate --preset objects --count 50 --seed 5000 --jobs $(JOBS) --out $(PROPOSALS)/objects
	$(BIN)/python -m benchmarks.atoms --root $(PROPOSALS)/objects --out docs/results/atoms_objects.json --jobs $(JOBS)
	$(BIN)/python docs/tables.py
