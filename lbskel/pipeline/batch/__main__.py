"""``python -m lbskel.pipeline.batch MEGABYTES``: the process that a WorkerProcess starts."""

import os
import sys

from lbskel.pipeline.batch.worker import serve

if __name__ == "__main__":
    replies = os.fdopen(os.dup(sys.stdout.fileno()), "w", encoding="utf-8")
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())  # what libraries print is no reply
    serve(sys.stdin, replies, float(sys.argv[1]))
