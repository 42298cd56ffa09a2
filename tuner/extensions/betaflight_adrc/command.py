"""The command `tuner adrc`."""

from pathlib import Path
from typing import Annotated

import typer

import tuner
from tuner.cli.answer import answer
from tuner.cli.app import AsJson, app
from tuner.text.pairs import named_text


@app.command()
def adrc(
    file: Annotated[
        Path,
        typer.Argument(
            help="Output of Betaflight's `diff all` or `dump all`, with pid_type = ADRC.", show_default=False
        ),
    ],
    plants: Annotated[
        Path | None,
        typer.Option(
            "--plant",
            help="Plants of the craft by axis (TOML), or the command lines whose b0 scales them; default: FILE.",
        ),
    ] = None,
    log: Annotated[
        Path | None, typer.Option(help="Flight log with setpoints (.bbl or CSV): identify the plants from it.")
    ] = None,
    profile: Annotated[int | None, typer.Option(help="PID profile; default: the selected one.", min=0, max=3)] = None,
    build: Annotated[str, typer.Option(help="Build: pr-august, b10.1, b11, pr or mp2; default: recognized.")] = "",
    gyro_rate: Annotated[float, typer.Option(help="Rate of the gyro [Hz]; default: 8000.")] = 0.0,
    growth: Annotated[float, typer.Option(help="Exponent of the acceleration gain over the throttle.")] = 0.5,
    gains: Annotated[
        Path | None, typer.Option(help="A gains.json of the law betaflight_adrc, whose settings replace the file's.")
    ] = None,
    gain: Annotated[
        list[str] | None,
        typer.Option(metavar="NAME=VALUE", help="Another value of a setting; give it again for others."),
    ] = None,
    pack: Annotated[
        list[float] | None, typer.Option(help="Another pack's voltage over the usual one; give it again for others.")
    ] = None,
    design: Annotated[
        float | None, typer.Option(help="Find wc and wo of each axis with this gain margin at every throttle and pack.")
    ] = None,
    noise: Annotated[float, typer.Option(help="Largest noise of such a tune over the present one.")] = 1.0,
    front: Annotated[
        Path | None, typer.Option(help="New PNG or PDF: bandwidth against margin and noise of such tunes.")
    ] = None,
    out: Annotated[Path | None, typer.Option(help="New file of command lines for this tune.")] = None,
    as_json: AsJson = False,
) -> None:
    """Forecast the axis that rings under Betaflight's ADRC, and what helps.

    Margins are of the linear loop by axis, throttle and schedule of b0, in flight and on the ground.

    Example: tuner adrc diff_all.txt --gyro-rate 3205

    Example: tuner adrc diff_all.txt --log chirp.bbl

    Example: tuner adrc diff_all.txt --gains results/adrc5/gains.json --out lines.txt

    Example: tuner adrc diff_all.txt --plant craft.toml --gain adrc_wo_yaw=80 --out lines.txt

    Example: tuner adrc diff_all.txt --log chirp.bbl --pack 0.85 --design 2 --front front.png --out lines.txt
    """
    settings = dict(named_text(text, "--gain", "adrc_wo_yaw=80") for text in gain or [])
    made = tuner.adrc(
        file,
        plants=plants,
        log=log,
        profile=profile,
        build=build,
        gyro_rate=gyro_rate,
        growth=growth,
        gains=gains,
        settings=settings,
        packs=pack or (),
        design=design,
        max_noise=noise,
        front=front,
        out=out,
    )
    answer(made, as_json)
