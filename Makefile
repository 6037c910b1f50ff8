# Every target makes .venv by itself when it is missing or out of date; nothing has to be typed first.

PYTHON ?= $(shell for p in python3.11 python3.12 python3.13 python3; do \
	$$p -c 'import sys; sys.exit(not (3, 11) <= sys.version_info < (3, 14))' 2>/dev/null && { echo $$p; break; }; done)
BIN := .venv/bin
STAMP := .venv/.installed
DEMO := out/demo
JOBS ?= 2
LEARN := data=folder data.root=$(DEMO)/train cache=$(DEMO)/examples jobs=$(JOBS)

# What a step of the demo does, and how long a command of it took.
step = @echo; echo "== Step $(1)"
timed = @begin=$$(date +%s); $(1) && echo "   done in $$(( $$(date +%s) - begin )) s"

.PHONY: setup demo test test-capabilities lint types bench docs pretrained proposals folds figures python
.DEFAULT_GOAL := setup

setup: $(STAMP)

python:
	@test -n "$(PYTHON)" || { echo "blockstab needs Python 3.11, 3.12 or 3.13, and none was found; install it, or name it: make PYTHON=/path/to/python3.11"; exit 1; }

$(STAMP): pyproject.toml constraints.txt | python
	@test -x $(BIN)/python || $(PYTHON) -m venv .venv
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -c constraints.txt torch
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -c constraints.txt -e '.[dev,docs]'
	$(BIN)/python -c 'from blockstab.commands.warm_up import warm_up; warm_up()'
	@touch $@

demo: $(STAMP)
	$(call step,1 of 5: simulate 24 scenes of blocks to learn from and 12 to test on)
	$(call timed,$(BIN)/blockstab simulate --preset blocks --count 24 --seed 1 --jobs $(JOBS) --out $(DEMO)/train)
	$(call timed,$(BIN)/blockstab simulate --preset blocks --count 12 --seed 2 --jobs $(JOBS) --out $(DEMO)/test)
	$(call step,2 of 5: train linear potentials on examples of the 24; the examples are kept)
	$(call timed,$(BIN)/python train.py potential=svm $(LEARN) output=$(DEMO)/svm)
	$(call step,3 of 5: train trees on the same examples)
	$(call timed,$(BIN)/python train.py potential=trees $(LEARN) output=$(DEMO)/trees)
	$(call step,4 of 5: parse the 12 with the trees)
	$(call timed,$(BIN)/blockstab parse $(DEMO)/test/*/ --potentials $(DEMO)/trees.json --jobs $(JOBS) --out $(DEMO)/parsed)
	$(call step,5 of 5: parse them in other ways too and score all)
	$(call timed,$(BIN)/python evaluate.py experiment=demo data=folder data.root=$(DEMO)/test potentials=$(DEMO)/trees.json out=$(DEMO)/evaluation jobs=$(JOBS))
	@echo "Look at the reports: $(DEMO)/parsed/*/report.html"

test: $(STAMP)
	OMP_NUM_THREADS=1 $(BIN)/python -m pytest -n $(JOBS) tests

# The tests with the instructions of older processors, which round otherwise; this one must have AVX2, if it is an x86.
test-capabilities: $(STAMP)
	for capability in default avx2; do \
		ATEN_CPU_CAPABILITY=$$capability OMP_NUM_THREADS=1 $(BIN)/python -m pytest -n $(JOBS) tests || exit 1; \
	done

lint: $(STAMP)
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .

types: $(STAMP)
	$(BIN)/mypy

bench: $(STAMP)
	mkdir -p out
	OMP_NUM_THREADS=1 $(BIN)/python -m pytest benchmarks --benchmark-columns=min,median,ops --benchmark-json=out/bench.json
	$(BIN)/python -m benchmarks.ratios out/bench.json

docs: $(STAMP)
	$(BIN)/python docs/tables.py --check
	$(BIN)/sphinx-build -W --keep-going -q -b html docs docs/_build
	@echo "docs/_build/index.html"

pretrained: $(STAMP)
	$(BIN)/python train.py data=mixed potential=trees ablations=[without_stability] output=models/pretrained/trees jobs=$(JOBS)
	$(BIN)/python train.py data=mixed potential=mlp fit.most_rows=20000 output=models/pretrained/mlp jobs=$(JOBS)
	$(BIN)/python train.py data=mixed potential=svm fit.most_rows=20000 output=models/pretrained/svm jobs=$(JOBS)
	$(BIN)/python train.py data=mixed potential=svm fit.most_rows=20000 features=paper fit.target=bit \
		output=models/pretrained/svm_paper jobs=$(JOBS)
	$(BIN)/python train.py task=boundary data.preset=objects output=models/pretrained/boundary jobs=$(JOBS)
	$(BIN)/python train.py task=stages data.preset=objects data.count=100 output=models/pretrained/silberman jobs=$(JOBS)

# First segmentations against each other: on simulated objects, half of which train, and on a folder of scenes in
# four folds, of which three train. make proposals OSD=path/of/osd
PROPOSALS := out/proposals
SIMULATED := data=simulated data.preset=objects data.count=100 data.seed=4000 split=halves
FOLDED = data=folder data.root=$(OSD) split=folds split.together=4
proposals: $(STAMP)
	@test -n "$(OSD)" || { echo "say where the scenes are: make proposals OSD=path/of/osd"; exit 1; }
	$(BIN)/python train.py task=stages $(SIMULATED) part=train output=$(PROPOSALS)/simulated jobs=$(JOBS)
	$(BIN)/python evaluate.py experiment=proposals experiment.methods.silberman.proposals.stages=$(PROPOSALS)/simulated.json $(SIMULATED) part=test \
		out=$(PROPOSALS)/simulated jobs=$(JOBS)
	cp $(PROPOSALS)/simulated/results.json docs/results/proposals_objects.json
	for fold in 0 1 2 3; do \
		$(BIN)/python train.py task=stages $(FOLDED) part=train$$fold output=$(PROPOSALS)/stages$$fold jobs=$(JOBS) && \
		$(BIN)/python evaluate.py experiment=proposals experiment.methods.silberman.proposals.stages=$(PROPOSALS)/stages$$fold.json $(FOLDED) \
			part=test$$fold out=$(PROPOSALS)/fold$$fold jobs=$(JOBS) || exit 1; \
	done
	$(BIN)/python docs/pool.py $(PROPOSALS)/fold?/results.json --out docs/results/proposals_osd.json
	$(BIN)/python -m benchmarks.atoms --root $(OSD) --out docs/results/atoms_osd.json --jobs $(JOBS)
	$(BIN)/blockstab simulate --preset objects --count 50 --seed 5000 --jobs $(JOBS) --out $(PROPOSALS)/objects
	$(BIN)/python -m benchmarks.atoms --root $(PROPOSALS)/objects --out docs/results/atoms_objects.json --jobs $(JOBS)
	$(BIN)/python docs/tables.py

# Potentials learned on three folds of a folder of scenes and tested on the fourth: make folds OSD=path/of/osd
FOLDS := out/folds
folds: $(STAMP)
	@test -n "$(OSD)" || { echo "say where the scenes are: make folds OSD=path/of/osd"; exit 1; }
	for fold in 0 1 2 3; do \
		$(BIN)/python train.py potential=trees $(FOLDED) part=train$$fold output=$(FOLDS)/trees$$fold jobs=$(JOBS) && \
		$(BIN)/python evaluate.py experiment=table4 'methods=[start,stability,rsamp]' \
			potentials=$(FOLDS)/trees$$fold.json $(FOLDED) part=test$$fold out=$(FOLDS)/fold$$fold \
			jobs=$(JOBS) || exit 1; \
	done
	$(BIN)/python docs/pool.py $(FOLDS)/fold?/results.json --out docs/results/table4_osd_folds.json
	$(BIN)/python docs/tables.py

# What searches do, on simulated scenes (Figures 11, 13 and 14 of the paper).
FIGURES := out/figures
FIGURE_SCENES := $(addprefix $(FIGURES)/objects/objects_,0001 0002)
figures: $(STAMP)
	for preset in blocks grocery objects; do \
		$(BIN)/blockstab simulate --preset $$preset --count 20 --seed 6000 --jobs $(JOBS) --out $(FIGURES)/$$preset && \
		$(BIN)/python evaluate.py experiment=figure13 data=folder data.root=$(FIGURES)/$$preset out=$(FIGURES)/$$preset-course \
			jobs=$(JOBS) && \
		cp $(FIGURES)/$$preset-course/results.json docs/results/figure13_$$preset.json || exit 1; \
	done
	$(BIN)/python docs/figures/energy.py docs/results/figure13_*.json
	$(BIN)/python docs/figures/potentials.py $(FIGURE_SCENES)
	$(BIN)/python docs/figures/sequence.py $(FIGURE_SCENES)
	$(BIN)/python docs/tables.py
