"""``python -m roughxr.cli``, where no script is installed."""

from . import main_of_process

if __name__ == "__main__":
    main_of_process()
