"""Compare methods: predict scenes to disk, then score the files. `python evaluate.py experiment=table4`."""

from models.programs.evaluate import main, methods_of, run

__all__ = ["main", "methods_of", "run"]

if __name__ == "__main__":
    main()
