"""Options of a command that exclude each other."""

import argparse


def find_contradiction(options: argparse.Namespace) -> str:
    """Return in words which options exclude each other, empty if none do."""
    if getattr(options, "scheduler", None) is not None and options.backend not in ("dask", "ray"):
        return f"--scheduler is for --backend dask or ray, not {options.backend}"
    if getattr(options, "window", None) is not None and getattr(options, "alignment", "dtw") != "dtw":
        return f"--window is the band of --alignment dtw, not {options.alignment}"
    if getattr(options, "ends", None) is not None and options.ends <= (options.begins or 0.0):
        return f"--to {options.ends:g} must be after --from {options.begins or 0:g}"
    if getattr(options, "pose", None) is not None and (options.begins, options.ends) != (None, None):
        return "--pose is a single pose, and --from and --to are for a motion: leave one of them out"
    if getattr(options, "endpoint", False) and not options.cycle:
        return "--endpoint is of --cycle: pass both"
    if options.command == "view":
        if (
            options.out is None
            and (options.png or options.gif)
            and not options.open
            and (options.align or options.overlay)
        ):
            return "--align and --overlay are for a page, and pictures show motions side by side: pass --out VIEW.html"
        if options.png is None and options.at is not None:
            return "--at is the time of --png: pass both"
        if options.gif is None and (options.begins, options.ends, options.fps) != (None, None, None):
            return "--from, --to and --fps are for --gif: pass it too"
        if options.fps is not None and not 0.1 <= options.fps <= 50:
            return (
                f"--fps must be from 0.1 to 50, as viewers show shorter pictures of a GIF longer, got {options.fps:g}"
            )
    if options.command == "retarget":
        if options.out is not None and len(options.files) > 1:
            return f"--out is for one motion, got {len(options.files)} files: leave --out out to compare the reports"
        if options.out is None and options.open:
            return "--open is of what --out writes: pass both"
        if options.joints is not None and options.method in ("numbers", "unchecked"):
            return f"--joints is for --method auto, orientations or positions, not {options.method}"
    return ""
