// Least squares of tall columns, and what is asked of small matrices.

import { Matrix, QrDecomposition, SVD } from "ml-matrix";

/** Rows that are decomposed at once, as far as they are at least four times as many as the columns. */
const ROWS = 1000;

/** The triangle of a QR decomposition of columns: it has the same products of columns. */
export function triangle(columns: readonly Float64Array[]): Matrix {
  const count = columns.length;
  const length = columns[0].length;
  const size = Math.max(ROWS, 4 * count);
  let above = Matrix.zeros(0, count);
  for (let first = 0; first < length; first += size) {
    const rows = Math.min(size, length - first);
    const block = Matrix.zeros(above.rows + rows, count);
    block.setSubMatrix(above, 0, 0);
    for (let column = 0; column < count; column += 1) {
      for (let row = 0; row < rows; row += 1) block.set(above.rows + row, column, columns[column][first + row]);
    }
    above = upper(block);
  }
  return above;
}

/** The upper triangle of a matrix, square even where there are fewer rows. */
export function upper(matrix: Matrix): Matrix {
  const count = matrix.columns;
  const tall = matrix.rows >= count ? matrix : Matrix.zeros(count, count).setSubMatrix(matrix, 0, 0);
  return new QrDecomposition(tall).upperTriangularMatrix;
}

/** Singular values, the largest first, and the directions of the parameters as columns. */
export function singular(matrix: Matrix): { values: number[]; left: Matrix; right: Matrix } {
  const { diagonal, leftSingularVectors, rightSingularVectors } = new SVD(matrix, { autoTranspose: true });
  return { values: diagonal, left: leftSingularVectors, right: rightSingularVectors };
}

/** The pseudo-inverse; singular values below a share of the largest count as 0. */
export function pseudoInverse(matrix: Matrix, share: number): Matrix {
  const { values, left, right } = singular(matrix);
  const largest = Math.max(...values, 0);
  const inverse = values.map((value) => (value > share * largest && value > 0 ? 1 / value : 0));
  return right.mmul(Matrix.diag(inverse)).mmul(left.transpose());
}

/** The solution of least squares, with least norm. */
export function leastSquares(matrix: Matrix, right: Matrix): Float64Array {
  return Float64Array.from(pseudoInverse(matrix, 1e-15).mmul(right).to1DArray());
}
