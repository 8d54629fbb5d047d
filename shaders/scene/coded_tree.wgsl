//@ implements mesh_tree when !siblings
//@ use bind/face_pairs
//@ use bind/nodes
// Trees of meshes whose nodes hold the codes of their children, as the tree of the scene does. A walk visits what a code names.

alias Visited = u32;

fn visit(code: u32) -> Visited {
    return code;
}

// The code of the node that is visited, or one of a pair of faces or a primitive.
fn visited_code(code: u32, visited: Visited) -> u32 {
    return code;
}

fn visited_node(visited: Visited) -> Node {
    return nodes[visited];
}

fn visited_pair(visited: Visited) -> FacePair {
    return face_pairs[primitive_index(visited)];
}

// A node's own code names its children.
fn children_of(code: u32, visited: Visited, in_mesh: bool) -> u32 {
    return code;
}

fn child_code(children: u32, number: u32, in_mesh: bool) -> u32 {
    return nodes[children].children[number];
}
