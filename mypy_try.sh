echo 12 > /proc/self/autogroup
export PATH=/tmp/h/h3/main/.venv/bin:$PATH
cd /tmp/h/h3/try; MYPYPATH=/tmp/h/h3/try/src:/tmp/h/h3/try mypy --cache-dir /tmp/h/h3/mc --python-executable /tmp/h/h3/main/.venv/bin/python > /tmp/h/h3/mypy_try.txt 2>&1
