"""Train what is learned: potentials, stages of merging, weights of edges. `python train.py potential=mlp`."""

from models.programs.train import main, run

__all__ = ["main", "run"]

if __name__ == "__main__":
    main()
