"""What child processes do for the page: read files from strangers, and search.

`asked` is what the page may ask for, checked field by field before a process is troubled; `tasks` does it; `worker` is
the loop of a child process. Messages are msgpack, so that nobody's bytes are unpickled. Start reading at `asked`.
"""
