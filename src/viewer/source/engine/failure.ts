// Failures of calls: a kind that the page tells apart, a message, and a hint.

export type Kind =
  | "not-found"
  | "network"
  | "no-archive"
  | "version"
  | "cut"
  | "damaged"
  | "too-large"
  | "other-place"
  | "other";

export interface Failure {
  kind: Kind;
  message: string;
  hint: string;
}

export class EngineError extends Error {
  readonly kind: Kind;
  readonly hint: string;

  constructor(failure: Failure) {
    super(failure.message);
    this.name = "EngineError";
    this.kind = failure.kind;
    this.hint = failure.hint;
  }
}

/** Returns an error as it crosses from the worker to the page. */
export function failureOf(error: unknown): Failure {
  if (error instanceof EngineError) {
    return { kind: error.kind, message: error.message, hint: error.hint };
  }
  return { kind: "other", message: error instanceof Error ? error.message : String(error), hint: "" };
}
