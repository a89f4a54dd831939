(comment) @comment.inside
(comment)+ @comment.around

(function body: (_) @function.inside) @function.around
(prefab body: (_) @class.inside) @class.around
(node body: (_) @class.inside) @class.around

(parameters (parameter) @parameter.inside)
(arguments (_) @parameter.inside)

(property value: (_) @entry.inside) @entry.around
