[
  (block)
  (key_block)
  (arm)
  (arguments)
  (parameters)
  (import_names)
  (list)
  (tuple)
  (comment)
] @fold
