"""Arguments and options that several commands share."""

from __future__ import annotations

from typing import Annotated

import typer

from engine.methods import METHODS

SceneArgument = Annotated[
    str,
    typer.Argument(metavar="SCENE", help="a built-in scene or a scene file", show_default=False),
]
MethodOption = Annotated[str, typer.Option("--method", help=f"one of {', '.join(METHODS)}")]
SetOption = Annotated[
    list[str] | None, typer.Option("--set", metavar="KEY=VALUE", help="a setting of the method")
]
SizeOption = Annotated[
    str | None, typer.Option("--size", metavar="WxH", help="pixels, in place of the scene's own")
]
AnyMethodOption = Annotated[
    str | None, typer.Option("--method", help=f"one of {', '.join(METHODS)}")
]
KindsOption = Annotated[
    str | None,
    typer.Option("--edits", help="what is to be edited: lights,environment,materials,camera"),
]
MethodsOption = Annotated[list[str] | None, typer.Option("--method", help="several may be given")]
