"""``python -m roughxr``, where no script is installed."""

from .cli import main_of_process

if __name__ == "__main__":
    main_of_process()
