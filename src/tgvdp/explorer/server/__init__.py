"""The server of the page: starlette behind a guard, and a queue of runs in child processes.

`app` has the routes, `guard` refuses what does not come from the page itself, `runs` keeps and queues runs,
`processes` starts and ends the child processes, `form` describes the options of a run. Only ``tgvdp explore`` imports
this room, which needs the extra ``web``. Start reading at `app`.
"""
