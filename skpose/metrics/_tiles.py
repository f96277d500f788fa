"""Tiles: the rectangles in which a matrix of distances is computed and written."""

from typing import NamedTuple

MIRROR_EDGE = 512  # of the squares that are transposed at once, for the cache's sake


class Tile(NamedTuple):
    """Rows top:bottom and columns left:right of a matrix."""

    top: int
    bottom: int
    left: int
    right: int

    @property
    def slices(self) -> tuple[slice, slice]:
        return slice(self.top, self.bottom), slice(self.left, self.right)

    @property
    def mirrored(self) -> "Tile":
        return Tile(self.left, self.right, self.top, self.bottom)

    @property
    def shape(self) -> tuple[int, int]:
        return self.bottom - self.top, self.right - self.left


class Tiling(NamedTuple):
    """A matrix in square tiles; where it is symmetric, those on the diagonal and above it stand for all."""

    shape: tuple[int, int]
    edge: int
    symmetric: bool

    def tiles(self) -> list[Tile]:
        """Return the tiles to compute, row by row."""
        n_rows, n_columns = self.shape
        return [
            Tile(top, min(top + self.edge, n_rows), left, min(left + self.edge, n_columns))
            for top in range(0, n_rows, self.edge)
            for left in range(top if self.symmetric else 0, n_columns, self.edge)
        ]

    def has(self, tile: Tile) -> bool:
        """Return whether this is one of the tiles."""
        n_rows, n_columns = self.shape
        top, left = tile.top, tile.left
        inside = 0 <= top < n_rows and (top if self.symmetric else 0) <= left < n_columns
        if not inside or top % self.edge or left % self.edge:
            return False
        return (tile.bottom, tile.right) == (min(top + self.edge, n_rows), min(left + self.edge, n_columns))

    def in_chunks(self, chunk: int, longest: int) -> "Tiling":
        """Return tiles that are made of whole square chunks of this edge, unless they would be longer than this."""
        return self if chunk > longest else self._replace(edge=max(chunk, self.edge // chunk * chunk))

    def is_in_chunks(self, chunk: int) -> bool:
        """Return whether each chunk belongs to one tile."""
        return self.edge % chunk == 0 or self.edge >= max(self.shape)

    def mirror_of(self, tile: Tile) -> Tile | None:
        """Return the tile that holds the same distances transposed, None where there is no other one."""
        return tile.mirrored if self.symmetric and tile.top != tile.left else None
