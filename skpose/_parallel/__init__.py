"""Threads, backends, progress and checkpoints: how long work is run; nothing here knows what is computed.

| module         |                                                                                        |
|----------------|----------------------------------------------------------------------------------------|
| `tasks`        | how large a task is                                                                    |
| `threads`      | tasks in threads of this process                                                       |
| `rows`         | rows of an array as such tasks                                                         |
| `backends`     | tasks in processes or on a cluster, as the user's joblib configuration says            |
| `progress`     | the state of long work: a bar or lines, and reports to a function that asked for them  |
| `callbacks`    | the same reports as steps of a fit, for scikit-learn's callbacks                       |
| `checkpoint`   | notes on a matrix that is not complete yet, in a file or in the attributes of an array |
| `lock`         | one process at a time on one destination, and the token by which workers recognise it  |
| `file_systems` | those on which two computers cannot write one file                                     |
"""
