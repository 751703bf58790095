# make demo: set up, run a short session from images, leave a video, a figure and a summary.
# make test: set up, run the tests.
PYTHON ?= python3
BIN := .venv/bin
OUT ?= out/demo
SETUP := command -v $(PYTHON) >/dev/null || { echo "setup: there is no $(PYTHON); Python 3.11 or later is needed"; exit 1; }; \
  $(PYTHON) tools/setup.py

.PHONY: demo from-images from-state test setup ready-to-test trained check docs
.DEFAULT_GOAL := demo

demo: setup
	@rm -rf $(OUT)
	@if $(PYTHON) tools/setup.py renders; then $(MAKE) --no-print-directory from-images; \
	  else $(MAKE) --no-print-directory from-state; fi

from-images:
	$(BIN)/jointattn session --minutes 3 --seed 0 --video --video-every 2 --out $(OUT)
	$(BIN)/jointattn session --minutes 0.5 --seed 1 --start-from assets/trained/robin.npz --video --video-every 2 --out $(OUT)/trained
	$(BIN)/jointattn session --minutes 0.5 --seed 1 --start-from assets/trained/robin_cross_situational.npz \
	  --preset cross_situational --video --video-every 2 --out $(OUT)/trained_cross_situational
	@echo
	@echo "Three minutes of a robot that begins to learn:  $(OUT)/video.mp4"
	@echo "The same robot after 26 minutes of learning:    $(OUT)/trained/video.mp4"
	@echo "Beside it, one that learns what is contingent:  $(OUT)/trained_cross_situational/video.mp4"
	@echo "Success over time, faces it knows, numbers:     $(OUT)/success.png  $(OUT)/som.png  $(OUT)/summary.json"

# Where nothing can be rendered.
from-state:
	@echo "No images can be rendered here: this demo runs from the simulator's state, and leaves no video."
	$(BIN)/jointattn session --minutes 26 --seed 0 --perception state --out $(OUT)
	@echo
	@echo "26 minutes of a robot that learns:              $(OUT)/success.png  $(OUT)/som.png  $(OUT)/summary.json"

test: ready-to-test
	$(BIN)/python -m pytest -n 2

check: ready-to-test
	$(BIN)/ruff check .
	$(BIN)/ruff format --check --quiet .
	$(BIN)/mypy

# The site, in out/site; a warning is an error.
docs: ready-to-test
	NO_MKDOCS_2_WARNING=1 $(BIN)/mkdocs build --strict --quiet
	@echo "Documentation: out/site/index.html"

# What `make demo` continues from: two robots after one session of chapter 6.
trained: setup
	$(BIN)/jointattn session --minutes 26 --seed 0 --out out/trained
	$(BIN)/jointattn session --minutes 26 --seed 0 --preset cross_situational --out out/trained_cross_situational
	mkdir -p assets/trained && cp out/trained/weights.npz assets/trained/robin.npz
	cp out/trained_cross_situational/weights.npz assets/trained/robin_cross_situational.npz

setup:
	@$(SETUP) demo

ready-to-test:
	@$(SETUP) test
