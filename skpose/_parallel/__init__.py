"""Threads, backends and progress of long work.

| module      |                                                                              |
|-------------|------------------------------------------------------------------------------|
| `tasks`     | sizes of tasks                                                               |
| `threads`   | tasks in threads of this process                                             |
| `rows`      | rows of an array as such tasks                                               |
| `backends`  | tasks in processes or on a cluster, as joblib's configuration says           |
| `progress`  | a bar or lines, and reports to other functions                               |
| `callbacks` | the same reports for scikit-learn's callbacks                                |
"""
