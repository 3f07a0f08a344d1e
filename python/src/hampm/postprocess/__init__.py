"""Pictures and tables of results, each a module with a command line; `hampm.commands` names them, `hampm.plot` returns their figures."""
