"""What makes an adapter of an engine that follows the public protocol, as all engines do."""
